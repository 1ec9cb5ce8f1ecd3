"""A preset's own scene in every extreme of step, wind and motion: what a user's hair has to go through.

Its strands, matter, rules and solids stay; of a large groom the first strands stand for all. Depths are told and not
judged, because only the preset's author knows which solids are meant to overlap.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np

from ...errors import UsageError
from ...groom.emit import emit
from ...groom.record import Groom
from ...scene.faults import shown
from ...scene.model import PoseKey, RuleUse, Scene
from ...scene.motion import emitter_pose
from ...simulate import solver_of
from ...simulate.rules import registry
from .axes import DEFAULTS, Case
from .drive import Meter
from .scenes import keys_of, times_of, wind_of
from .sheets import values
from .task import Task
from .verdicts import Verdict, judge, told_of

VARIED = ("dt", "substeps", "wind", "emitter")
MOST_STRANDS = 256
DEPTH = "only who wrote a preset knows which solids are meant to overlap"
STRETCHES = "strands of the rules stretch where elasticity is not among them"
AFTER_WIND = ("stiffness", "collision", "elasticity")


def tasks(scene: Scene, solver: str | None = None) -> list[Task]:
    """One piece of work for each combination, by the preset's own solver unless another is given."""
    if scene.panels:
        raise UsageError(f"{scene.source}: draws several panels; stress one preset at a time")
    which = solver or scene.solver
    found = []
    for labels in product(*(values(axis) for axis in VARIED)):
        given = dict(zip(VARIED, labels, strict=True))
        words = [f"{axis}={label}" for axis, label in given.items() if label != DEFAULTS[axis]]
        found.append(Task(which, named="/".join(["preset", *words]), scene=scene, labels=labels))
    return found


def named(scene: Scene, name: str) -> Task:
    """The piece of work with a name. Raises `UsageError` where there is none."""
    for solver in ("rod", "thesis"):
        for task in tasks(scene, solver):
            if task.names == (name,):
                return task
    raise UsageError(f"--case {shown(name)}: no case of a preset; strandcli stress PRESET --list names them")


def perform(task: Task) -> Verdict:
    """The verdict on one combination."""
    assert task.scene is not None
    labels = dict(zip(VARIED, task.labels, strict=True))
    case = Case.of(task.solver, labels)
    times = times_of(case)
    scene = changed(replace(task.scene, solver=task.solver), case)
    groom = emit(scene.emitter, scene.seed, MOST_STRANDS)
    name = task.names[0]
    try:
        with np.errstate(all="ignore"):
            metrics = _drive(scene, groom, times)
    except UsageError:
        raise
    except Exception as error:  # whatever a solver raises is what is looked for here
        return judge(name, labels, {}, f"{type(error).__name__}: {error}")
    told = {"penetration": DEPTH, "segment_penetration": DEPTH, **told_of(case)}
    if task.solver == "thesis" and not any(use.name == "elasticity" for use in scene.rules):
        told["stretch"] = STRETCHES
    return judge(name, labels, metrics, unjudged=told)


def changed(scene: Scene, case: Case) -> Scene:
    """The scene with a case's wind and motion. Times are those of the case."""
    times = times_of(case)
    rules = list(scene.rules)
    place = next((i for i, use in enumerate(rules) if use.name in AFTER_WIND), len(rules))
    length = scene.emitter.length
    if case.value("wind"):
        if scene.solver == "rod":  # which lets gusts travel where there is no other wind
            rules = [_at_once(use) for use in rules]
        parameters = registry()["wind"].Parameters(**wind_of(case.value("wind") * length, float(times[0])))
        rules.insert(place, RuleUse("wind", parameters, "wind"))
    emitter = scene.emitter
    if case.label("emitter") != "still":
        if not any(use.name == "emitter_motion" for use in rules):
            rules.insert(0, RuleUse("emitter_motion", registry()["emitter_motion"].Parameters(), "emitter_motion"))
        home = emitter_pose(emitter, 0.0).translation
        turned = emitter.keys[0].rotation if emitter.keys else emitter.rotation
        keys = tuple(
            PoseKey(
                key.time,
                tuple(a + length * b for a, b in zip(home, key.position, strict=True)),  # type: ignore[arg-type]
                tuple(a + b for a, b in zip(turned, key.rotation, strict=True)),  # type: ignore[arg-type]
                "step",
            )
            for key in keys_of(case, times)
        )
        emitter = replace(emitter, keys=keys)
    emitter = replace(emitter, strands=min(emitter.strands, MOST_STRANDS))
    return replace(scene, rules=tuple(rules), emitter=emitter)


def _at_once(use: RuleUse) -> RuleUse:
    """A wind with gusts that are everywhere at once, and any other rule as it is."""
    return replace(use, parameters=replace(use.parameters, wavelength=0.0)) if use.name == "wind" else use


def _drive(scene: Scene, groom: Groom, times: np.ndarray) -> dict[str, float]:
    solver = solver_of(scene)(scene, groom)
    segments = groom.lengths.astype(np.float64) / (scene.emitter.particles - 1)
    meter = Meter(scene, segments, scene.emitter.length, touching=any(use.name == "collision" for use in scene.rules))
    meter.overlapping = False
    meter.follow(solver, times)
    return meter.metrics(slice(None))
