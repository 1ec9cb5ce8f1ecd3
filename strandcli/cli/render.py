"""`strandcli render`: a preset to PNG frames, a report, and an animation where asked."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..common.counted import counted
from ..errors import SimulationError, StrandError
from ..files import inputs
from . import options, render_frames, render_options, signals
from .preview import Preview, preview_option
from .progress import Progress, Talk, warner
from .render_frames import advised, frame_line, frame_writer, interrupted, max_error_option, open_cache, tell
from .sweep import run as run_sweep
from .sweep import sweep_option
from .values import FrameRange
from .watch import run as run_watch
from .watch import watch_option

if TYPE_CHECKING:
    from ..output.frames import FrameWriter
    from ..output.report import RunReport
    from ..run.frame import Frame
    from ..scene.model import Scene


@click.command()
@options.drawn
@options.folder("out/PRESET")
@options.frames
@options.scene_options
@options.quality
@options.threads
@max_error_option
@render_options.animation_options
@render_options.layer_options
@render_options.cameras
@options.from_cache
@options.checkpoint
@options.keep_going
@options.memory_check
@click.option("--no-html", is_flag=True, help="Write no report.html.")
@render_frames.option
@sweep_option
@watch_option
@preview_option
@options.resume_or_overwrite
@options.talk_options
@inputs.recording()
def command(
    preset: str, output: Path | None, frames: FrameRange | None, threads: int | None,
    max_error: dict[str, float] | None, animate: tuple[str, ...] | None, over: tuple[int, int, int] | None,
    aovs: tuple[str, ...] | None, exr: bool, cameras: Path | None, camera: str | None, from_cache: Path | None,
    checkpoint: int | None, keep_going: bool, memory_check: bool, no_html: bool, dask: str | None,
    sweep: tuple[Any, ...], watch: bool, preview: str | None, resume: bool, overwrite: bool, talk: Talk,
    **scene_settings: Any,
) -> None:  # fmt: skip
    """Simulate and draw PRESET, which is a file or a shipped name ('strandcli presets' lists them), or draw a FILE of
    strands as it is.

    Writes frame_0001.png …, report.json and report.html. However the run ends, finished frames stay and are whole. A
    run that goes wrong stops at once: where a coordinate is not finite, a segment is stretched beyond 1 % (rod) or 100
    times its length (thesis), or the solver's iterations leave it off by its whole length. With --max-error a study
    finds the cheapest settings that stay under it: for motion substeps, iterations and particles; for the picture
    (picture=2%, flip=0.05) samples, curves, shadow maps and level of detail. Settings given by hand stay.
    """
    if watch or sweep:
        given = click.get_current_context().params
        run_watch(given) if watch else run_sweep(command.callback, given)  # type: ignore[arg-type]
        return
    options.exclusive(max_error="motion" in (max_error or {}), from_cache=from_cache is not None)
    options.exclusive(checkpoint=checkpoint is not None, from_cache=from_cache is not None)
    render_options.require_file(cameras, camera)
    scene_settings["aovs"] = aovs
    if cameras is not None:
        changes, notes = render_options.film(preset, cameras, scene_settings["size"], camera)
        scene_settings["overrides"] = (*changes, *scene_settings["overrides"])
        for words in notes:
            talk.note(f"warning: {words}")
    scene = options.load_scene(preset, **scene_settings)
    picture_error = None
    if max_error is not None:
        scene, picture_error = advised(preset, max_error, scene_settings, threads, talk)
    scene = render_options.with_layers(scene, exr)
    render_frames.require_cluster(scene, dask)
    ground = render_options.ground(scene, animate or (), over)
    numbers = options.frame_numbers(frames, scene, from_cache)

    from ..plan import checked_plan

    plan = checked_plan(scene, numbers, check=memory_check)
    from ..html_report import page, run
    from ..output.files import require_own
    from ..output.report import RunReport  # NumPy, once memory suffices
    from ..scene import dump

    positions = open_cache(from_cache, numbers, scene, keep_going)
    folder = output or options.default_folder(preset)
    writer = frame_writer(folder, numbers, scene, positions, animate or (), overwrite, resume, exr)
    label = options.preset_name(preset)
    report = RunReport(label, scene.sha256, plan, writer.scene)
    report.picture_error = picture_error
    if not (no_html or overwrite):
        require_own(writer.directory / run.FILE, page.is_report)
    settings = {"threads": threads, "positions": positions, "keep_going": keep_going}
    with talk.progress(len(writer.wanted), label) as progress:
        by = checkpoint, dask, not no_html
        data = _run(scene, writer, report, by, settings, talk.quiet, progress, Preview(preview))
    made = render_options.animate(writer, data, animate or (), overwrite or resume, scene.time.fps, ground, talk)
    if not no_html:
        run.write(writer.directory, data, dump(scene), made)
    talk.data(data)
    if not talk.quiet:
        tell(data, writer, made)


def _run(
    scene: Scene, writer: FrameWriter, report: RunReport, by: tuple[int | None, str | None, bool],
    settings: dict[str, Any], quiet: bool, progress: Progress, shown: Preview,
) -> dict[str, Any]:  # fmt: skip
    """Draw what is wanted, and write the report however that ends; ``by``: frames between two checkpoints, the Dask
    cluster that draws, and whether a run that fails has its page, too; ``settings``: of `run.pipeline.render`."""
    from ..compiling import runtime
    from ..compiling.service import service
    from ..run import checkpoints

    warn = warner(progress, quiet, report.warnings.append)
    _warn_of_foreign(writer, warn)
    for words in report.plan_warnings:
        warn(words)
    before = runtime.compile_seconds()  # a study may have compiled already
    status = "failed"
    started = False
    try:
        with writer:
            settings |= {"notify": progress.note, "warn": warn}
            settings["checkpoints"] = checkpoints.of_run(writer.directory, by[0], warn, progress.note)
            if writer.wanted:
                if not scene.panels:  # before Numba is imported here, which takes half a second
                    service.ahead(scene, settings["threads"])
                runtime.start(settings["threads"], progress.note)
                started = True
                for frame in _drawer(by[1])(scene, writer.wanted, **settings):
                    report.add(frame.number, frame.report)
                    if frame.image is not None:  # it is, where draw is not turned off
                        writer.submit(frame.number, frame.image, frame.aovs)
                        shown.next(frame.image)
                    progress.checked_step(frame_line(frame.number, frame.report))
            if stale := inputs.changed():
                warn(stale)
        status = "complete"
    except SimulationError as error:
        if error.trouble is not None:
            report.fail(error.trouble)
        raise
    except KeyboardInterrupt:
        status = "interrupted"
        if not quiet:
            progress.line(interrupted(writer))
        raise
    finally:
        compiled = runtime.compile_seconds() - before if started else None
        data = _report(report, writer, status, runtime.machine() if started else None, compiled)
        if by[2] and data and status != "complete":
            from ..html_report.run import write
            from ..scene import dump

            with suppress(StrandError, OSError):  # what ended the run says more than what might go wrong here
                write(writer.directory, data, dump(scene))
    return data


def _drawer(dask: str | None) -> Callable[..., Iterator[Frame]]:
    """What draws frames: this process, or the workers of a Dask cluster."""
    if dask is None:
        from ..run.pipeline import render

        return render
    from ..dask_cluster.cluster import frames_of_cluster

    return functools.partial(frames_of_cluster, address=dask, check=signals.check)


def _warn_of_foreign(writer: FrameWriter, warn: Callable[[str], None]) -> None:
    """Warn where the folder holds frames of another scene or other settings, which this run leaves there."""
    from ..output.report import of_another_film, read_report

    numbers = (*writer.wanted, *writer.written)
    foreign = of_another_film(writer.directory, writer.scene, read_report(writer.directory), numbers)
    if foreign:
        there = f"{counted(len(foreign), 'frame')} there of another scene or other settings, such as {foreign[0]}"
        warn(f"{writer.directory}: {there}; choose another folder with -o")


def _report(
    report: RunReport,
    writer: FrameWriter,
    status: str,
    machine: Mapping[str, Any] | None,
    compile_seconds: float | None,
) -> dict[str, Any]:
    """Write report.json, with what it says there of frames that this run has not drawn."""
    from ..output.claim import Claim
    from ..output.report import PATIENCE, finite, foreign_entries, read_report, write_report

    claim, data = None, {}
    try:
        claim = Claim(writer.directory, "report", patience=PATIENCE)
        previous = read_report(writer.directory)
        if machine is None and previous is not None:
            machine = previous.get("machine")
        foreign = foreign_entries(writer.directory, writer.scene, previous, writer.written)
        data = finite(report.as_dict(status, writer.written, machine, compile_seconds, previous, foreign))
        write_report(writer.directory, data)
    except StrandError:
        if status == "complete":  # else what ended the run says more
            raise
    finally:
        if claim is not None:
            claim.release()
    return data
