"""What was meant by a setting that there is not: where it belongs, what it was once, or what other programs call it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping

from .faults import hint, near, shown
from .fields import settings_of
from .model import Scene
from .rule_type import RuleType
from .specs import ModelSpec, UnionSpec

MOST_PATHS = 3
"""Paths that a message suggests at the most."""
_TRACED = ("0.1.0", "exact shadows are no part of this version; use opacity")
GONE: Mapping[str, tuple[str, str]] = {
    "children.fringe": ("0.1.0", "shorter hair at an edge is a groom of its own; take it out"),
    "emitter.shape.ragged": ("0.1.0", "the edge of a cap is even; take it out"),
    "emitter.tie.over": ("0.1.0", "tied strands lie over the shape that they grow on alone; take it out"),
    "lights.*.shadow.model: nearby": _TRACED,
    "lights.*.shadow.model: traced": _TRACED,
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
"""By dotted path, `*` for any solid or light, with the value where only that is gone: the last version that had it, and
what to do instead."""
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


def hint_inside(key: str, known: Iterable[str], rules: Mapping[str, RuleType]) -> str:
    """The end of a message about a key that is none of ``known`` at the top: the paths of the settings with this name,
    else what was probably meant, else all ``known`` keys."""
    names = list(known)
    paths = settings_by_name(rules)
    found = key if key in paths else None if near(key, names) else near(key, paths)
    if found is None:
        return hint(key, names, "the keys are")
    level = paths[found][0].count(".")  # they come level by level; deeper ones are meant less often
    nearest = [path for path in paths[found] if path.count(".") == level]
    return f"did you mean {' or '.join(shown(path) for path in nearest[:MOST_PATHS])}?"


def settings_by_name(rules: Mapping[str, RuleType]) -> dict[str, list[str]]:
    """Dotted paths of all settings below the top that are not in lists, by their last part, level by level."""
    paths: dict[str, list[str]] = {}
    for path in _paths(rules):
        paths.setdefault(path.rpartition(".")[2], []).append(path)
    return paths


def _paths(rules: Mapping[str, RuleType]) -> Iterator[str]:
    """Dotted paths of all settings below the top that are not in lists."""
    waiting = [(key, setting.spec) for key, setting in settings_of(Scene).items()]
    while waiting:
        path, spec = waiting.pop(0)
        if isinstance(spec, ModelSpec):
            models = [spec.model]
        elif isinstance(spec, UnionSpec):
            models = list(spec.kinds.values())
        else:
            continue
        inner = {f"{path}.{key}": setting.spec for model in models for key, setting in settings_of(model).items()}
        yield from inner
        waiting += inner.items()
    for name, rule in rules.items():
        yield from (f"{name}.{key}" for key in settings_of(rule.Parameters))


def why_absent(path: str, value: str = "") -> str | None:
    """Return why there is no setting at a dotted path, or around it, or no such ``value`` of it; None where nobody
    looks for one."""
    path = re.sub(r"^(solids|lights)\.[^.]+", r"\1.*", path)
    if value:
        found = GONE.get(f"{path}: {value}")
        return None if found is None else f"{shown(value)} is gone after {found[0]}; {found[1]}"
    if (meant := ELSEWHERE.get(path.rpartition(".")[2])) is not None:
        return f"unknown key; did you mean {meant}?"
    while path and path not in GONE and path not in NEVER:
        path = path.rpartition(".")[0]
    return f"gone after {GONE[path][0]}; {GONE[path][1]}" if path in GONE else NEVER.get(path)
