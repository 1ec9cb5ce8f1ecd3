"""Decisions on the stages of simulation: rules, keys, pre-roll."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from ..common.counted import counted
from ..scene.motion import deforming_ground
from ..scene.rule_type import OWN_OF
from ..simulate.rules import idle, registry
from .decision import Decision, left_out

if TYPE_CHECKING:
    from ..scene.model import Scene


def motion_decisions(scene: Scene, strands: int) -> Iterator[Decision]:
    """Yield the decisions on the stages of simulation; strands: number of simulated ones."""
    emitter = scene.emitter
    if strands < emitter.strands:
        hidden = f"{emitter.strands - strands} of {emitter.strands}"
        yield left_out("strands", f"{hidden} are too far to be drawn in any frame")
    listed = {use.name for use in scene.rules}
    for use in scene.rules:
        why = idle(use, scene)
        if use.name in OWN_OF.get(scene.solver, ()):
            why = "rod lengths are exact and rods bend by their material"
        yield Decision(f"rule {use.name}", why or "the preset lists it", runs=not why)
    for name in registry():
        if name not in listed:
            yield left_out(f"rule {name}", "the preset does not list it")
    if "emitter_motion" not in listed and (len(emitter.keys) > 1 or deforming_ground(scene) is not None):
        yield left_out(
            "emitter keys" if emitter.keys else "deform under the roots",
            "no rule emitter_motion carries the roots along",
        )
    if not _moving(scene):
        return
    if scene.time.preroll == 0:
        yield left_out("pre-roll", "its time is zero")
    else:
        yield Decision("pre-roll", f"{scene.time.preroll:g} s, {counted(_preroll_steps(scene), 'step')} before frame 1")


def solver_steps(scene: Scene, frames: Sequence[int]) -> int:
    """Return the number of solver steps up to the last of the frames, including the pre-roll."""
    if not _moving(scene):
        return 0
    return _preroll_steps(scene) + (max(frames, default=1) - 1) * scene.time.substeps


def _moving(scene: Scene) -> bool:
    return any(not idle(use, scene) for use in scene.rules)


def _preroll_steps(scene: Scene) -> int:
    return round(scene.time.preroll * scene.time.fps * scene.time.substeps)
