"""How long a run will take here."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from ..plan.cost import kind_of, run_seconds
from .profile import Profile

if TYPE_CHECKING:
    from ..plan import Plan
    from ..scene.model import Scene

WITHIN = 2.0
"""Times by which the figures may be off, on a machine that does nothing else."""


class Foretold(NamedTuple):
    """Seconds of a run with kernels in the cache, and where they are from."""

    frame: float
    """A frame, of those that are drawn at once its share."""
    total: float
    threads: int
    within: float
    source: str


def foretell(plan: Plan, scene: Scene, profile: Profile, threads: int) -> Foretold:
    """Return the seconds of a run on so many threads."""
    factor, runs = profile.of(kind_of(scene))
    frame, total = run_seconds(plan, scene, factor, threads)
    if runs:
        source = f"by {'the last run' if runs == 1 else f'{runs} runs'} of such scenes here"
    else:
        source = f"by a calibration of this machine on {profile.measured}"
    return Foretold(frame, total, threads, WITHIN, source)
