"""`strandcli plan`: what would run; runs nothing."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import click

from . import options
from .frame_range import FrameRange
from .say import say

if TYPE_CHECKING:
    from ..scene.model import Emitter, Scene


LOOKED_AT = 100_000
"""Strands that are looked at for warnings: ten million would take half a minute and gigabytes."""


@click.command()
@options.drawn
@options.frames
@options.scene_options
@options.quality
@options.as_json
@options.debug
def command(preset: str, frames: FrameRange | None, as_json: bool, **scene_settings: Any) -> None:
    """Tell what rendering PRESET would run, what is left out and why, the memory it would take, and what is hardly
    meant. Runs nothing."""
    scene = options.load_scene(preset, **scene_settings, roughly=True)
    numbers = options.frame_numbers(frames, scene)

    from ..plan import make_plan
    from ..scene.named_files import naming_files

    for drawn in scene.panels or (scene,):
        if drawn.environment is not None:
            from ..draw.lighting.environment import read

            with naming_files(scene):
                read(drawn.environment.image)
    plan = make_plan(scene, numbers)
    with naming_files(scene):
        warnings = [*_warnings(scene, numbers), *plan.warnings]
    if as_json:
        options.print_json({**dataclasses.asdict(plan), "warnings": warnings})
        return
    stages = [(one.stage, one.why) for one in (*plan.used, *plan.left_out)]
    width = max((len(stage) for stage, _ in stages), default=0)
    for title, part in (("Runs", plan.used), ("Left out", plan.left_out)):
        say(f"{title}:")
        for one in part:
            say(f"  {one.stage:<{width}}  {one.why}")
        if not part:
            say("  nothing")
    _totals(plan)
    for words in warnings:
        say(f"warning: {words}", err=True)


def _warnings(scene: Scene, numbers: Any) -> list[str]:
    """What `render` would warn of before it simulates, of `LOOKED_AT` strands; of panels with their labels."""
    from ..groom.emit import emit
    from ..plan import needed_strands
    from ..scene.model import MeshShape
    from ..simulate.advice import warnings

    found = []
    for one in scene.panels or (scene,):
        if one.emitter.groom is not None:
            from ..groom_file import from_scene  # Numba comes with it

            lines = list(from_scene(one, roughly=True).notes)
        else:
            groom = emit(one.emitter, one.seed, min(needed_strands(one, numbers), LOOKED_AT))
            lines = []
            if isinstance(one.emitter.shape, MeshShape):
                from ..groom.deforming import at_start  # Numba comes with it

                lines = _of_mesh(one.emitter)
                groom = at_start(one, groom)
            lines += warnings(one, groom)
        found += [f"{one.label}: {words}" if one.label else words for words in lines]
    return found


def _of_mesh(emitter: Emitter) -> list[str]:
    """What there is to know of the mesh of an emitter; reading meshes takes Numba."""
    from ..groom.on_mesh import notes

    return notes(emitter)


def _totals(plan: Any) -> None:
    frames = "1 frame" if plan.frames == 1 else f"{plan.frames:,} frames"
    say("Cost:")
    say(f"  {plan.strands:,} strands, {plan.particles:,} particles, {plan.steps:,} solver steps for {frames}")
    say(f"  at most {plan.segments_max:,} line pieces on {plan.samples:,} samples a frame")
    say(f"  about {plan.memory_bytes / 1e6:,.0f} MB of memory")
