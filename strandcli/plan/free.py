"""Available memory, and refusal of a run that would use more."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..errors import RefusedError
from . import limits

if TYPE_CHECKING:
    from .make import Plan


def require_memory(plan: Plan) -> None:
    """Raise `RefusedError` if a plan's estimate exceeds the available memory."""
    free = available_memory()
    if free is not None and plan.memory_bytes > free:
        fewer = (
            "draw fewer of the file's strands with --strands" if plan.of_file else "use fewer --strands or --particles"
        )
        raise RefusedError(
            f"this run would take about {plan.memory_bytes / 1e9:.1f} GB and {free / 1e9:.1f} GB are free: "
            f"{fewer}, or a smaller --size"
        )


def available_memory() -> int | None:
    """Return the available bytes, by the system and by the control groups of this process; None if neither is known."""
    found = []
    try:
        with open("/proc/meminfo", encoding="ascii") as lines:
            found += [1024 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable")]
    except OSError:
        pass
    left = limits.memory_left()
    if left is not None:
        found.append(left)
    return min(found, default=None)
