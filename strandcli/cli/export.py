"""`strandcli export`: the strands that a preset draws, as a file for other programs."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..common.counted import counted
from . import options
from .progress import Talk, warner
from .render_frames import open_cache
from .values import FrameRange

if TYPE_CHECKING:
    from ..exchange.strands import Strands, TimeSample
    from ..run.export import DrawnFrame
    from ..scene.model import Scene

LEVELS = {str(2**level): level for level in range(9)}


@click.command()
@options.drawn
@click.argument("target", type=options.PathType(), metavar="OUT")
@options.frames
@options.scene_options
@options.quality
@click.option(
    "--pieces", type=click.Choice(tuple(LEVELS)), metavar="N",
    help="Pieces that each segment between particles is cut into: 1, 2, 4 … 256.  [default: as `curves` says]",
)  # fmt: skip
@options.threads
@options.from_cache
@options.keep_going
@options.overwrite
@options.talk_options
def command(
    preset: str, target: Path, frames: FrameRange | None, pieces: str | None, threads: int | None,
    from_cache: Path | None, keep_going: bool, overwrite: bool, talk: Talk, **scene_settings: Any,
) -> None:  # fmt: skip
    """Write the strands that PRESET draws, children among them, as the file OUT, in the format that its name ends in.

    Points are in metres, y up, root to tip, in the order of emission; widths are those that are drawn. .abc and .usd
    hold all frames, frame N at N / fps seconds; of other formats each frame is a file: OUT_0001.hair, …. Files of USD
    have the preset's camera, too.
    """
    from ..exchange import files

    moving = bool(getattr(files.writer_of(target), "moving", False))
    scene = options.load_scene(preset, **scene_settings)
    numbers = options.frame_numbers(frames, scene, from_cache)
    several = len(numbers) > 1 and not moving
    name = f"{target.stem}_{{:04d}}{target.suffix}" if several else target.name
    paths = {number: target.with_name(name.format(number)) for number in numbers}
    for path in dict.fromkeys(paths.values()):
        options.refuse_existing(path, overwrite)

    from ..plan import checked_plan

    checked_plan(scene, numbers)
    positions = open_cache(from_cache, numbers, scene, keep_going)
    lost: dict[str, None] = {}
    with talk.compiled(len(numbers), options.preset_name(preset), threads) as progress:
        from ..run.export import drawn_strands

        def stepped() -> Iterator[DrawnFrame]:
            for one in drawn_strands(
                scene, numbers, level=None if pieces is None else LEVELS[pieces], threads=threads,
                positions=positions, keep_going=keep_going, notify=progress.note,
                warn=warner(progress, talk.quiet),
            ):  # fmt: skip
                yield one
                progress.checked_step(f"frame {one.number}")

        found = _write(stepped(), paths, moving and len(numbers) > 1, scene, lost)
    _report(target, found, len(numbers), list(dict.fromkeys(paths.values())), list(lost), talk)


def _write(
    found: Iterator[DrawnFrame], paths: dict[int, Path], moving: bool, scene: Scene, lost: dict[str, None]
) -> Strands:
    """Write the frames, all into one file or each into its own; returns the first one's strands."""
    from ..cameras.read import camera_layer
    from ..exchange import files
    from ..exchange.strands import TimeSample

    first = next(found)
    if scene.emitter.groom is not None:
        from ..groom_file import completed

        scene = completed(scene)  # its camera may depend on the strands

    def samples() -> Iterator[TimeSample]:
        for one in chain([first], found):
            yield TimeSample(one.number / scene.time.fps, one.strands.points)

    if moving:
        camera = camera_layer(scene, list(paths))
        lost |= dict.fromkeys(files.write(paths[first.number], first.strands, samples(), camera))
        return first.strands
    for one in chain([first], found):
        lost |= dict.fromkeys(files.write(paths[one.number], one.strands, beside=camera_layer(scene, [one.number])))
    return first.strands


def _report(target: Path, strands: Strands, frames: int, paths: list[Path], lost: list[str], talk: Talk) -> None:
    """Say what was written."""
    points = strands.points.shape[0]
    if not strands.attributes:
        lost = [*lost, "material.width is 0, lines one pixel wide: no widths are written"]
    if talk.as_json:
        talk.data({"out": [str(path) for path in paths], "frames": frames, "strands": strands.count,
                            "points": points, "lost": lost})  # fmt: skip
        return
    for line in lost:
        talk.note(line)
    where = str(target) if len(paths) == 1 else f"{paths[0]} … {paths[-1].name}"
    each = f", {frames:,} frames" if frames > 1 else ""
    talk.note(f"{where}: {counted(strands.count, 'strand')}, {points:,} points{each}")
