"""What a rule hands to the composer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple


class Moment(NamedTuple):
    """What a rule may ask when it prepares its numbers for one solver step."""

    time: float
    """End of the step in seconds; frame 1 is at 0, the pre-roll before it."""
    step: float
    """Length of the step in seconds."""
    scene: Any
    """The validated `Scene`."""

    @property
    def pose_time(self) -> float:
        """Time at which keys are read: during the pre-roll everything is held."""
        return max(self.time, 0.0)


@dataclass(frozen=True)
class Pass:
    """One function of the fused step.

    ``function`` is plain Python without closures, compiled later. With ``stage="particle"`` its signature is
    ``(x, parent, grandparent, root, length, p, i, n)``: rows of particle i, of i - 1, of i - 2 (for i = 1 the root
    minus one segment along the strand's direction, thesis §2), of the root, each ``(3 * W,)`` float32; the segment
    rest lengths ``(W,)``; the array that ``prepare`` returned; the index and the number of particles. It changes ``x``
    alone.
    With ``stage="root"`` it is ``(clamp, root, rest_clamp, rest_root, p)``: the row before the root, the root, and the
    same two in the emitter's own frame; it changes the first two.

    ``prepare(moment)`` returns the float32 array ``p`` for a step.
    """

    function: Callable[..., None]
    prepare: Callable[[Moment], Any]
    stage: str = "particle"
