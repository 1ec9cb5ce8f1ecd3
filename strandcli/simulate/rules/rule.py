"""What a rule hands to the composer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from ...scene.model import Scene


class Moment(NamedTuple):
    """What a rule may ask when it prepares its numbers for one solver step."""

    time: float
    """End of the step in seconds; frame 1 is at 0, the pre-roll before it."""
    step: float
    """Length of the step in seconds."""
    scene: Scene
    """The validated `Scene`."""

    @property
    def pose_time(self) -> float:
        """Time at which keys are read: during the pre-roll everything stands still, unless the motion repeats."""
        return float(self.scene.time.pose_time(self.time))


@dataclass(frozen=True)
class Pass:
    """One function of the fused step: plain Python without closures, compiled later.

    ``stage="lane"``, the usual kind: ``(a, b, c, length, p)`` gives back the new place of a particle at a. The three
    places are tuples of x, y, z in metres: of particle i, of i - 1, of i - 2 (for i = 1 the root minus one segment
    along the strand's direction, thesis §2); length is the rest length of a segment; p a tuple of ``numbers`` numbers.
    Neighbouring passes of this kind become one loop, and that vector code, if they do not branch: choose between two
    values, not between two branches.

    ``stage="particle"``: ``(x, parent, grandparent, root, length, p, i, n)`` changes ``x`` alone and has its own loops
    over the lanes. Rows of particle i, of i - 1, of i - 2 and of the root, each ``(3 * W,)`` float32: x of every lane,
    then y, then z; lengths ``(W,)``; the array p; the index and the number of particles.

    ``stage="root"``: ``(clamp, root, rest_clamp, rest_root, p)`` changes the first two: the row before the root and the
    root, and the same in the emitter's own frame.

    ``prepare(moment)`` returns the float32 array p for a step: ``(numbers,)`` for a lane pass or, with
    ``per_particle``, ``(n, numbers)``, a row for each particle. It follows from the moment alone, and is asked for
    several steps at once; a rule that remembers earlier steps keeps that in the arrays ``state``, which it changes in
    place, so that checkpoints have it, and steps are prepared one by one.
    """

    function: Callable[..., Any]
    prepare: Callable[[Moment], Any]
    stage: str = "particle"
    numbers: int = 0
    per_particle: bool = False
    state: tuple[Any, ...] = ()
