"""All axes of study, by name."""

from __future__ import annotations

from collections.abc import Mapping

from ..errors import UsageError
from .axes import Axis
from .motion.experiment import Motion
from .motion.interaction import Interaction
from .pictures.coverage import CoverageStudy
from .pictures.frame import QualityStudy
from .pictures.occlusion import OcclusionStudy
from .pictures.shadow import ShadowStudy
from .references.experiment import References

AXES: Mapping[str, Axis] = {
    axis.name: axis
    for axis in (
        Axis("motion", Motion),
        Axis("interaction", Interaction),
        Axis("reference", References),
        Axis("coverage", CoverageStudy, True),
        Axis("shadow", ShadowStudy, True),
        Axis("occlusion", OcclusionStudy, True),
        Axis("quality", QualityStudy, True),
    )
}


def find(name: str) -> Axis:
    """An axis by name. Raises `UsageError`."""
    if name not in AXES:
        raise UsageError(f"no axis '{name}'; the axes are {', '.join(AXES)}")
    return AXES[name]
