"""All axes of study, by name."""

from __future__ import annotations

from collections.abc import Mapping

from ..errors import UsageError
from .axes import Experiment
from .motion.experiment import Motion
from .pictures.frame import CoverageStudy, QualityStudy
from .pictures.occlusion import OcclusionStudy
from .pictures.shadow import ShadowStudy
from .references.experiment import References

AXES: Mapping[str, type[Experiment]] = {
    one.axis: one for one in (Motion, References, CoverageStudy, ShadowStudy, OcclusionStudy, QualityStudy)
}


def find(name: str) -> type[Experiment]:
    """An axis by name. Raises `UsageError`."""
    if name not in AXES:
        raise UsageError(f"no axis '{name}'; the axes are {', '.join(AXES)}")
    return AXES[name]
