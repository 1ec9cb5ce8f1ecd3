"""Frames of `strandcli render`: the positions that they are drawn of, what takes them, what is said of them; workers of
a Dask cluster (``--dask``); and settings from studies (``--max-error``)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..common.counted import counted
from ..errors import UsageError
from . import completion, options
from .progress import Talk, duration, pace, say
from .values import Parsed, bounds

if TYPE_CHECKING:
    from ..output import positions
    from ..output.frames import FrameWriter
    from ..output.positions import PositionCache
    from ..scene.model import Scene


def frame_writer(
    folder: Path, numbers: tuple[int, ...], scene: Scene, cache: PositionCache | None, animate: tuple[str, ...],
    overwrite: bool, resume: bool, exr: bool,
) -> FrameWriter:  # fmt: skip
    """What takes the frames; refuses up front what would be refused later."""
    from ..output.frames import FrameWriter
    from ..output.report import FILE
    from ..run.fingerprint import fingerprint

    if "mp4" in animate:
        from ..output.animation import ffmpeg

        ffmpeg()
    return FrameWriter(
        folder,
        numbers,
        picture_size(scene),
        overwrite=overwrite,
        resume=resume,
        scene=fingerprint(scene, *([] if cache is None else other_motion(cache, scene))),
        also=[f"animation.{kind}" for kind in animate],
        own=[FILE],
        layers=scene.image.aovs,
        exr=exr,
    )


def picture_size(scene: Scene) -> tuple[int, int]:
    """Width and height of what is drawn; panels, their gaps and their labels included."""
    if not scene.panels:
        return scene.image.drawn
    import numpy as np

    from ..run.panels import join

    empty = [np.zeros((*panel.image.drawn[::-1], 3), np.uint8) for panel in scene.panels]
    height, width, _ = join(empty, [panel.label for panel in scene.panels]).shape
    return width, height


def motion_of(scene: Scene) -> positions.Motion:
    """What positions of a scene follow from."""
    from ..output.positions import Motion
    from ..run.fingerprint import motion_fingerprint, motion_values

    values = motion_values(scene)
    return Motion(motion_fingerprint(values), values)


def open_cache(
    directory: Path | None, frames: tuple[int, ...], scene: Scene, keep_going: bool = False
) -> PositionCache | None:
    """The checked folder of --from-cache; with ``keep_going`` its positions need not be finite. Raises `UsageError`
    where strands of the scene move otherwise."""
    if directory is None:
        return None
    from ..output.positions import PositionCache
    from ..run.fingerprint import difference
    from ..scene.detail import with_before

    if scene.panels:
        raise UsageError("--from-cache: a preset of several panels has several sets of positions; draw it without")
    frames = tuple(with_before(scene, frames))
    cache = PositionCache(directory, frames, scene.emitter.strands, scene.emitter.particles, finite=not keep_going)
    if cache.motion is not None:
        differs = difference(motion_of(scene).settings, cache.motion.settings)
        if differs:
            raise UsageError(
                f"{directory}: was simulated with another {differs.removesuffix('.')}, which moves strands otherwise; "
                "simulate it anew, or give the preset and the options that it was simulated with"
            )
    return cache


def other_motion(cache: PositionCache, scene: Scene) -> list[str]:
    """What frames drawn from positions depend on beside the scene: nothing where it would simulate the very same."""
    if cache.motion is None:
        return [str(cache.directory.resolve()), cache.digest]
    return [] if cache.motion.fingerprint == motion_of(scene).fingerprint else [cache.motion.fingerprint]


def interrupted(writer: FrameWriter, besides: str = "") -> str:
    """Say that a run was interrupted, and how many frames stay."""
    from ..output.files import count_there

    there = count_there(writer.directory / one.file for one in writer.written.values())
    finished = counted(there, "finished frame")
    return f"{writer.directory}: interrupted; {besides}{finished} stay, --resume continues"


def frame_line(number: int, report: Mapping[str, Any]) -> str:
    """The line of a frame for --verbose: milliseconds of its stages, and its errors."""
    stages = [f"{name} {1000 * value:.1f}" for name, value in report.get("seconds", {}).items() if value is not None]
    errors = [f"{name} {value:.2g}" for name, value in report.get("error", {}).items() if value is not None]
    return f"frame {number}: {', '.join(stages)} ms; {', '.join(errors)}"


def tell(data: Mapping[str, Any], writer: FrameWriter, made: list[Path]) -> None:
    """Print what a run made, how long it took and what it retained."""
    drawn = len(writer.wanted)
    earlier = len(writer.written) - drawn
    totals = data["totals"]
    words = f"{writer.directory}: {counted(drawn, 'frame')} in {_seconds(totals['seconds'])}"
    compiling = data["compile_seconds"] or 0.0
    if compiling:
        words += f", of which {compiling:.1f} s compiling (only on first use)"
    drawing = totals["seconds"] - compiling
    if drawn > 1 and drawing > 0:
        words += f": {pace(drawn, drawing)}"
    if earlier:
        words += f"; {earlier} kept"
    for path in made:
        words += f"; {path.name}"
    say(f"{words}; {_written(writer, made)}", err=True)


def _written(writer: FrameWriter, made: list[Path]) -> str:
    """What the frames' files take, retained ones too, with their layers and the animations."""
    from ..output.files import megabytes
    from ..output.layers import layer_files

    names = [one.file for one in writer.written.values()]
    names += [name for frame in writer.written for name in layer_files(frame, writer.layers, writer.exr)]
    paths = [*(writer.directory / name for name in names), *made]
    return megabytes(sum(path.stat().st_size for path in paths if path.exists()))


def _seconds(seconds: float) -> str:
    return f"{seconds:.1f} s" if seconds < 60 else duration(seconds)


option = options.together(
    options.alone("dask", "max_error"),
    click.option(
        "--dask", metavar="ADDRESS", shell_complete=completion.clusters,
        help="Let the workers of a Dask cluster draw: 'local', or a scheduler such as tcp://HOST:8786.",
    ),
)  # fmt: skip


def require_cluster(scene: Scene, address: str | None) -> None:
    """Raise `UsageError` where workers are asked for, and cannot draw a scene or be asked by this machine."""
    if address is None:
        return
    from ..dask_cluster.cluster import require_dask

    if scene.panels:
        raise UsageError("--dask: a preset of several panels has several sets of positions; draw it without")
    if not address.strip():
        raise UsageError("--dask: the address is empty; write local, or a scheduler's address such as tcp://HOST:8786")
    require_dask()


max_error_option = click.option(
    "--max-error", type=Parsed("ERRORS", bounds), metavar="ERRORS",
    help="Errors to stay under: of motion 1% or motion=1%, of the picture picture=2%, to the eye flip=0.05; "
    "several separated by commas.",
)  # fmt: skip


def advised(
    preset: str, bounds: Mapping[str, float], given: dict[str, Any], threads: int | None, talk: Talk
) -> tuple[Scene, Mapping[str, Any] | None]:
    """The scene with the settings that studies choose, and what the report says of its picture's error; None where that
    is not asked for. What the user has set (``given``, as `options.load_scene` takes it) is left alone."""
    scene = options.load_scene(preset, **given)
    fixed = {text.partition("=")[0].strip() for text in given["overrides"]}
    if given["particles"] is not None:
        fixed.add("emitter.particles")
    if "motion" in bounds:
        given = {**given, "overrides": (*given["overrides"], *_motion(scene, preset, bounds, fixed, talk))}
        scene = options.load_scene(preset, **given)
    asked = {name: most for name, most in bounds.items() if name != "motion"}
    if not asked:
        return scene, None
    if given["quality"] is not None or "quality" in fixed:
        raise UsageError("--quality: --max-error chooses how finely a picture is drawn; leave one of the two out")
    from ..study.advice import METRICS, advise_picture
    from ..study.sweep import changed

    name = options.preset_name(preset)
    wanted = {METRICS[one]: most for one, most in asked.items()}
    with talk.compiled(1, "study", threads, each="run", lines=True) as progress:
        advice = advise_picture(scene, name, wanted, sorted(fixed), progress.checked_step, progress.begin)
    _report(name, asked, advice.text(), talk)
    return changed(scene, advice.settings), advice.report


def _motion(scene: Scene, preset: str, bounds: Mapping[str, float], fixed: set[str], talk: Talk) -> tuple[str, ...]:
    """Settings of motion under an error, as after --set."""
    from ..study.advice import advise

    name = options.preset_name(preset)
    with talk.compiled(1, "study", 1, each="run", lines=True) as progress:  # on a thread, as `strandcli study` does
        advice = advise(scene, name, bounds["motion"], sorted(fixed), progress.checked_step, progress.begin)
    _report(name, {"": bounds["motion"]}, advice.text(), talk)
    return tuple(f"{path}={value}" for path, value in advice.settings.items())


def _report(name: str, asked: Mapping[str, float], text: str, talk: Talk) -> None:
    from ..study.report import share

    words = ", ".join(f"{one} {share(most)}".strip() for one, most in asked.items())
    talk.note(f"{name}: under {words}: {text}")
