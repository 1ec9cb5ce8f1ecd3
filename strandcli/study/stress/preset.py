"""A preset's own scene in every extreme of step, wind and motion: what a user's hair has to go through.

Its strands, matter, rules and solids stay; of a large groom the first strands stand for all. Depths are not judged,
because only the preset's author knows which solids are meant to overlap.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from ...errors import UsageError
from ...groom.emit import emit
from ...scene.faults import shown
from ...scene.model import PoseKey, RuleUse, Scene
from ...scene.motion import emitter_pose
from ...simulate import solver_of
from ...simulate.rules import registry
from .axes import DEFAULTS, SOLVERS, Case
from .drive import Meter
from .matrix import values
from .scenes import keys_of, times_of, wind_of
from .verdicts import Verdict, judge, unjudged_of

VARIED = ("dt", "substeps", "wind", "emitter")
MOST_STRANDS = 256
DEPTH = "only who wrote a preset knows which solids are meant to overlap"
STRETCHES = "strands of the rules stretch where elasticity is not among them"
AFTER_WIND = ("stiffness", "collision", "elasticity")


@dataclass(frozen=True)
class PresetCase:
    """A scene with the labels that it is run with."""

    scene: Scene
    case: Case

    @property
    def name(self) -> str:
        """What it is called: the solver and all that departs from the defaults."""
        labels = ((axis, self.case.label(axis)) for axis in VARIED)
        words = [f"{axis}={label}" for axis, label in labels if label != DEFAULTS[axis]]
        return "/".join([self.case.solver, "preset", *words])


def cases_of(scene: Scene, solver: str | None = None) -> list[PresetCase]:
    """A case for each combination, by the preset's own solver unless another is given."""
    if scene.panels:
        raise UsageError(f"{scene.source}: draws several panels; stress one preset at a time")
    which = solver or scene.solver
    labels = (dict(zip(VARIED, row, strict=True)) for row in product(*map(values, VARIED)))
    return [PresetCase(scene, Case.of(which, row)) for row in labels]


def named(scene: Scene, name: str) -> PresetCase:
    """The case with a name. Raises `UsageError` where there is none."""
    for solver in SOLVERS:
        for one in cases_of(scene, solver):
            if one.name == name:
                return one
    raise UsageError(f"--case {shown(name)}: no case of a preset; strandcli stress PRESET --list names them")


def perform(one: PresetCase) -> Verdict:
    """The verdict on one combination."""
    case, labels = one.case, {axis: one.case.label(axis) for axis in VARIED}
    scene = changed(replace(one.scene, solver=case.solver), case)
    groom = emit(scene.emitter, scene.seed, MOST_STRANDS)
    rules = [use.name for use in scene.rules]
    segments = groom.lengths.astype(np.float64) / (scene.emitter.particles - 1)
    meter = Meter(scene, segments, scene.emitter.length, touching="collision" in rules)
    meter.overlapping = False
    try:
        with np.errstate(all="ignore"):
            meter.follow(solver_of(scene)(scene, groom), times_of(case))
    except UsageError:
        raise
    except Exception as error:  # whatever a solver raises is what is looked for here
        return judge(one.name, labels, {}, f"{type(error).__name__}: {error}")
    unjudged = {"penetration": DEPTH, "segment_penetration": DEPTH, "pinned_off": DEPTH, **unjudged_of(case)}
    if case.solver == "thesis" and "elasticity" not in rules:
        unjudged["stretch"] = STRETCHES
    return judge(one.name, labels, meter.metrics(slice(None)), unjudged=unjudged)


def changed(scene: Scene, case: Case) -> Scene:
    """The scene with a case's wind and motion. Times are those of the case."""
    times, length, emitter = times_of(case), scene.emitter.length, scene.emitter
    rules = list(scene.rules)
    if case.value("wind"):
        place = next((i for i, use in enumerate(rules) if use.name in AFTER_WIND), len(rules))
        if scene.solver == "rod":  # which lets gusts travel where there is no other wind
            rules = [_at_once(use) for use in rules]
        parameters = registry()["wind"].Parameters(**wind_of(case.value("wind") * length, float(times[0])))
        rules.insert(place, RuleUse("wind", parameters, "wind"))
    if case.label("emitter") != "still":
        if not any(use.name == "emitter_motion" for use in rules):
            rules.insert(0, RuleUse("emitter_motion", registry()["emitter_motion"].Parameters(), "emitter_motion"))
        home = emitter_pose(emitter, 0.0).translation
        turned = emitter.keys[0].rotation if emitter.keys else emitter.rotation
        keys = []
        for key in keys_of(case, times):
            at, rotation = np.add(home, np.multiply(length, key.position)), np.add(turned, key.rotation)
            keys.append(PoseKey(key.time, tuple(at.tolist()), tuple(rotation.tolist()), "step"))
        emitter = replace(emitter, keys=tuple(keys))
    emitter = replace(emitter, strands=min(emitter.strands, MOST_STRANDS))
    return replace(scene, rules=tuple(rules), emitter=emitter)


def _at_once(use: RuleUse) -> RuleUse:
    """A wind with gusts that are everywhere at once, and any other rule as it is."""
    return replace(use, parameters=replace(use.parameters, wavelength=0.0)) if use.name == "wind" else use
