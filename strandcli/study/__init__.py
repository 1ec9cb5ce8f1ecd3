"""Measuring instruments: how right, how fast and how stable everything else is. What runs presets needs none."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING

from ..errors import UsageError

if TYPE_CHECKING:
    from .sweep import Experiment


@cache
def axes() -> Mapping[str, type[Experiment]]:
    """The axes that there are, by name."""
    from .motion import Motion
    from .pictures.frame import CoverageStudy, QualityStudy
    from .pictures.shadow import ShadowStudy
    from .references import References

    return {one.axis: one for one in (Motion, References, CoverageStudy, ShadowStudy, QualityStudy)}


def find(name: str) -> type[Experiment]:
    """An axis by name. Raises `UsageError`."""
    if name not in axes():
        raise UsageError(f"no axis '{name}'; the axes are {', '.join(axes())}")
    return axes()[name]
