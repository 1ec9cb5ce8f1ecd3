"""Settings that presets had once or that people look for, and what to do instead."""

from __future__ import annotations

import re
from collections.abc import Mapping

from .faults import shown

GONE: Mapping[str, tuple[str, str]] = {
    "rod.end: clamped": ("0.1.0", "use pinned: the tip stays where it is emitted and turns freely"),
    "rod.end_keys": ("0.1.0", "pinned tips go where the emitter carries them; take it out"),
    "rod.integrator": ("0.1.0", "steps are of second order, shorter where swings ask for it; damping calms motion"),
    "rod.material: wire": ("0.1.0", "write its numbers: density: 7850, radius: 2.5e-4, young: 2.0e+11"),
    "rod.material: wool": ("0.1.0", "write its numbers: density: 1310, radius: 1.2e-5, young: 3.0e+9"),
    "rod.precision": ("0.1.0", "it is double where single would not be enough; take it out"),
    "rod.root: free": ("0.1.0", "use hinged, which lets strands turn, and move the emitter"),
    "rod.section": ("0.1.0", "strands are round; give the radius that bends as they should as rod.radius"),
    "rod.yield_strain": ("0.1.0", "strands spring back to their rest shape; take it out"),
    "solids.*.blend": ("0.1.0", "solids stay apart; use kind: mesh for one smooth body, or take it out"),
}
"""By dotted path, `*` for any solid, with the value where only that is gone: the last version that had it, and what to
do instead."""
NEVER: Mapping[str, str] = {
    "rod.twist": "how much strands resist it is torsion; write that",
    "rod.mass": "mass follows from density and radius; write those",
    "rod.stiffness": "bending stiffness follows from young and radius; write those",
    "rod.stretch": "rods do not stretch",
}
"""What to do instead of settings that no version had, by dotted path."""
ELSEWHERE: Mapping[str, str] = {
    "antialiasing": "image.supersample=2",
    "depth_of_field": "camera.aperture=0.01",
    "dof": "camera.aperture=0.01",
    "motion_blur": "camera.shutter=0.5",
    "motionblur": "camera.shutter=0.5",
    "res": "image.size=[800, 600]",
    "resolution": "image.size=[800, 600]",
    "transparency": "image.background=none",
    "transparent": "image.background=none",
}
"""Names that other programs have for a setting, and the setting as ``--set`` takes it."""


def why_absent(path: str, value: str = "") -> str | None:
    """Return why there is no setting at a dotted path, or around it, or no such ``value`` of it; None where nobody
    looks for one."""
    path = re.sub(r"^solids\.[^.]+", "solids.*", path)
    if value:
        found = GONE.get(f"{path}: {value}")
        return None if found is None else f"{shown(value)} is gone after {found[0]}; {found[1]}"
    if (meant := ELSEWHERE.get(path.rpartition(".")[2])) is not None:
        return f"unknown key; did you mean {meant}?"
    while path and path not in GONE and path not in NEVER:
        path = path.rpartition(".")[0]
    return f"gone after {GONE[path][0]}; {GONE[path][1]}" if path in GONE else NEVER.get(path)
