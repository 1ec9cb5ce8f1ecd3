"""A study that recommends nothing: how near each solver comes, and what to try."""

from __future__ import annotations

import math
from collections.abc import Sequence

from .chart import share
from .sweep import Study


def why_missed(studies: Sequence[Study], most: float) -> str:
    """Why nothing could be recommended: how near each solver comes, and what to try."""
    words = [f"{study.name}: {_nearest(study)}" for study in studies]
    return f"no setting keeps under an error of {share(most)}: {'; '.join(words)}; {_remedy(studies)}"


def _nearest(study: Study) -> str:
    """How near each solver that presets may ask for comes."""
    found = []
    for solver in dict.fromkeys(point.solver for point in study.offered):
        limit = study.reference.get("limits", {}).get(solver)
        if limit is not None and not limit["converges"]:
            gap = limit["gaps"][1]
            moved = f" (its last refinement moved strands by {share(gap)})" if math.isfinite(gap) else ""
            found.append(f"{solver} has no limit in sight{moved}")
            continue
        errors = [point.error.get(study.metric) for point in study.offered if point.solver == solver]
        known = [error for error in errors if error is not None]
        sure = f", its limit known to {share(limit['uncertainty'])}" if limit is not None else ""
        found.append(f"{solver} comes to {share(min(known))}{sure}".strip() if known else f"{solver} has no error")
    return ", ".join(found)


def _remedy(studies: Sequence[Study]) -> str:
    """What to try: first of all segments as short as strands bend."""
    if any(study.axis == "interaction" for study in studies):
        return "try finer --cells or more --guides"
    if any(study.axis not in ("motion", "reference") for study in studies):
        return "allow a greater error"
    for study in studies:
        bend = study.reference.get("bend")
        tried = [point.knobs["emitter.particles"] for point in study.offered if "emitter.particles" in point.knobs]
        if bend and tried and bend * (max(tried) - 1) < 1:
            need = math.ceil(1 / bend) + 1
            return (
                f"strands bend within {share(bend)} of their length, less than a segment: "
                f"try --solver rod --particles {need},{2 * need - 1}"
            )
    return "try finer --substeps or --particles"
