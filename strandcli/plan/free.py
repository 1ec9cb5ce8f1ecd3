"""Available memory."""

from __future__ import annotations

from . import limits

SHARE = 0.8
"""Of what is free, what a run may be planned to take: the estimate may be 15 % off, and other programs grow."""


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
