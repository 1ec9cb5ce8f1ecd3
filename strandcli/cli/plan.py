"""`strandcli plan`: what would run; runs nothing."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import click

from ..common.counted import counted
from ..common.limits import cores
from ..compiling import runtime
from . import options
from .progress import Progress, duration, pace, print_json, say
from .values import FrameRange

if TYPE_CHECKING:
    from ..plan import Plan
    from ..scene.model import Scene


LOOKED_AT = 100_000
"""Strands that are looked at for warnings: ten million would take half a minute and gigabytes."""


@click.command()
@options.drawn
@options.frames
@options.scene_options
@options.quality
@options.threads
@click.option(
    "--time", "measure", is_flag=True, help="Measure this machine first, for two seconds, if that was not done yet."
)
@options.as_json
def command(
    preset: str, frames: FrameRange | None, threads: int | None, measure: bool, as_json: bool, **scene_settings: Any
) -> None:
    """Report what rendering PRESET would run, what it would leave out and why, its memory and time, and settings that
    are probably mistakes. Runs nothing of it.

    Memory is estimated within 15 %, and time within a factor of 2 on an otherwise idle machine with compiled kernels.
    For time the machine's speed must be known: --time or 'strandcli doctor --calibrate' measures it once.
    """
    scene = options.load_scene(preset, **scene_settings)
    # a million frames as numbers are 40 MB
    numbers = range(1, scene.time.frames + 1) if frames is None else options.frame_numbers(frames, scene)

    from ..output.files import frame_bytes
    from ..plan import make_plan
    from ..scene.named_files import naming_files

    for drawn in scene.panels or (scene,):
        if drawn.environment is not None:
            from ..draw.lighting.environment import read

            with naming_files(scene):
                read(drawn.environment.image)
    threads = threads or cores()
    plan = make_plan(scene, numbers, threads=threads)
    time = _expected(plan, scene, threads, measure)
    with naming_files(scene):
        try:
            warnings = [*_warnings(scene, numbers), *plan.warnings]
        except NotImplementedError as error:
            if not runtime.lacks_compiler(error):
                raise
            warnings = [*plan.warnings, f"solids and meshes were not looked at: {runtime.NO_COMPILER}"]
    written = frame_bytes(plan.pixels, scene.image.aovs)
    if as_json:
        from ..output.report import plan_stages

        sizes = plan.sizes and plan.sizes._asdict()
        more = {"warnings": warnings, "sizes": sizes, "frame_bytes": written, "time": time}
        data = {**dataclasses.asdict(plan), **(plan_stages(plan) or {}), **more}
        del data["parts"]
        print_json(data)
        return
    width = max((len(one.stage) for one in (*plan.used, *plan.left_out)), default=0)
    for title, part in (("Runs", plan.used), ("Left out", plan.left_out)):
        lines = [f"{one.stage:<{width}}  {one.why}" for one in part] or ["nothing"]
        say("\n  ".join([f"{title}:", *lines]))
    _totals(plan, written)
    _time(plan, time)
    for words in warnings:
        say(f"warning: {words}", err=True)


def _warnings(scene: Scene, numbers: Any) -> list[str]:
    """What `render` would warn of before it simulates, of `LOOKED_AT` strands; of panels with their labels. Raises
    `UsageError` for what it would refuse of what strands do to each other."""
    from ..groom.emit import emit
    from ..plan.decisions import labelled
    from ..scene.detail import needed_strands
    from ..scene.model import MeshShape
    from ..simulate.advice import warnings
    from ..simulate.rod.material import require_between

    found = []
    for one in scene.panels or (scene,):
        if one.emitter.groom is not None:
            from ..groom_file import from_scene, notes_of  # Numba comes with it

            read = from_scene(one)
            lines = [*read.notes, *notes_of(one, read.moments)]
        else:
            groom = emit(one.emitter, one.seed, min(needed_strands(one, numbers), LOOKED_AT))
            lines = []
            if isinstance(one.emitter.shape, MeshShape):
                from ..groom.deforming import at_start  # Numba comes with it
                from ..groom.on_mesh import notes

                lines = notes(one.emitter)
                groom = at_start(one, groom)
            require_between(one, groom)
            lines += warnings(one, groom)
        found.append((one.label, lines))
    return labelled(found)


def _totals(plan: Plan, written: int) -> None:
    from ..common.limits import SHARE, available_memory
    from ..output.files import megabytes

    say("Cost:")
    strands, steps = counted(plan.strands, "strand"), counted(plan.steps, "solver step")
    say(f"  {strands}, {plan.particles:,} particles, {steps} for {counted(plan.frames, 'frame')}")
    say(f"  at most {counted(plan.segments_max, 'line piece')} on {counted(plan.samples, 'sample')} a frame")
    several = ""
    if plan.frames_at_once > 1:
        more = f"{plan.memory_at_once_bytes / 1e6:,.0f} MB with {plan.frames_at_once} frames at once"
        several = f", {more}; fewer are drawn where that does not fit"
    say(f"  about {plan.memory_bytes / 1e6:,.0f} MB of memory, within 15 %, by the sizes of its parts{several}")
    if (free := available_memory()) is not None:
        too_much = f"; more than {100 * SHARE:.0f} % of that is refused" if plan.memory_bytes > SHARE * free else ""
        say(f"  {free / 1e6:,.0f} MB are free{too_much}")
    whole = megabytes(written * plan.frames)
    say(f"  at most about {megabytes(written)} of files a frame, {whole} for {counted(plan.frames, 'frame')}")


def _expected(plan: Plan, scene: Scene, threads: int, measure: bool) -> dict[str, Any] | None:
    """How long it takes, where the machine's speed is known or to be measured."""
    from .. import calibration
    from ..plan.cost import run_seconds

    known = calibration.read()
    if known is None and measure:
        with Progress(1, "calibration") as progress:
            known = calibration.measure(progress.note)
        calibration.write(known)
    if known is None:
        return None
    frame, total = run_seconds(plan, scene, known.factor, threads)
    source = f"by a calibration of this machine on {known.measured}"
    return {"frame": frame, "total": total, "threads": threads, "within": calibration.WITHIN, "source": source}


def _time(plan: Plan, found: dict[str, Any] | None) -> None:
    if found is None:
        say("  time is not known: add --time, or run 'strandcli doctor --calibrate', to measure this machine once")
        return
    run = f"{counted(plan.frames, 'frame')} on {counted(found['threads'], 'thread')}"
    say(f"  about {pace(1, found['frame'])}, {duration(found['total'])} for {run}, within a factor of "
        f"{found['within']:g}, {found['source']}; compiling is not counted")  # fmt: skip
