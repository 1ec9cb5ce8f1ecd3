"""All axes of study, by name."""

from __future__ import annotations

from collections.abc import Mapping

from ..errors import UsageError
from . import exactness, motion
from .axes import Axis
from .motion import crowding
from .pictures import coverage, curves, end_to_end, lod, occlusion, quality_front, shadow, tables


def every() -> Mapping[str, Axis]:
    """All axes by name."""
    drawn = (
        curves.AXIS,
        coverage.AXIS,
        shadow.AXIS,
        occlusion.AXIS,
        lod.AXIS,
        tables.AXIS,
        end_to_end.AXIS,
        quality_front.AXIS,
    )
    return {axis.name: axis for axis in (motion.AXIS, crowding.AXIS, exactness.AXIS, *drawn)}


def find(name: str) -> Axis:
    """An axis by name. Raises `UsageError`."""
    axes = every()
    if name not in axes:
        raise UsageError(f"no axis '{name}'; the axes are {', '.join(axes)}")
    return axes[name]
