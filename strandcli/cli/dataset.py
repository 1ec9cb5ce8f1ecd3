"""`strandcli dataset`: labelled views of grooms, in the layouts that other programs read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..common.counted import counted
from ..common.registry import LAYOUTS
from ..errors import UsageError
from . import completion, options, render_options
from .progress import Talk, warner
from .values import span


@click.command()
@click.argument("grooms", nargs=-1, required=True, metavar="GROOM...", shell_complete=completion.presets)
@click.option("--layout", required=True, metavar="NAME", help=f"One of {', '.join(LAYOUTS.names())}.")
@click.option("--views", type=options.Whole(1, 1_000_000), metavar="N", help="Views of each groom.  [default: 8]")
@click.option("--first", type=options.Whole(0, 1_000_000), default=0, help="Number of the first view, to make parts.")
@options.folder()
@render_options.cameras
@click.option("--azimuth", type=span(360), default=(-180.0, 180.0), help="Degrees around, from the scene's camera.")
@click.option("--elevation", type=span(90), default=(-10.0, 40.0), help="Degrees above the horizon, such as -10,40.")
@click.option(
    "--light",
    type=click.Choice(("view", "set", "scene")),
    help="Light: new for each view, one for the set, or the scene's.",
)
@click.option("--colour", type=click.Choice(("view", "set", "scene")), help="The same for the strands' colour.")
@click.option("--frame", type=options.Whole(1, 1_000_000), default=1, help="Frame of a preset that moves.")
@options.scene_options
@options.quality
@options.threads
@options.memory_check
@options.resume_or_overwrite
@options.talk_options
def command(
    grooms: tuple[str, ...], layout: str, views: int | None, first: int, output: Path, cameras: Path | None,
    camera: str | None, azimuth: tuple[float, float], elevation: tuple[float, float], light: str | None,
    colour: str | None, frame: int, threads: int | None, memory_check: bool, resume: bool, overwrite: bool,
    talk: Talk, **scene_settings: Any,
) -> None:  # fmt: skip
    """Draw labelled views of each GROOM, which is a file of strands, a preset, or a shipped preset's name, into DIR, or
    with several grooms into a folder of each there.

    View k depends on --seed and k alone. Whatever ends the run, finished views are complete, and --resume continues.
    """
    render_options.require_file(cameras, camera)
    from ..cameras.pinhole import UP
    from ..cameras.read import Views, views_of
    from ..dataset import run as sets
    from ..dataset.views import EACH, ONE, Chance, layout_of, names_of, numbers_for, scene_for, size_for
    from ..plan import checked_plan

    kind = layout_of(layout)
    _require_files(grooms)
    usual = EACH if kind.own_light else ONE
    found = Views((), True) if cameras is None else views_of(cameras, scene_settings["size"], name=camera or "")
    size = size_for(kind, scene_settings.pop("size"), found.views, cameras)
    numbers = numbers_for(views, first, found.views, cameras)
    made, heard = [], set[str]()
    for groom, name in zip(grooms, names_of(grooms), strict=True):
        given = {
            **scene_settings,
            "overrides": (*render_options.world(groom, found, cameras), *scene_settings["overrides"]),
        }
        scene = scene_for(options.load_scene(groom, size=size, **given), kind, size, frame)
        checked_plan(scene, [frame], check=memory_check)
        folder = output / name if len(grooms) > 1 else output
        chance = Chance(scene_settings["seed"] or 0, name, light or usual, colour or usual, azimuth, elevation)
        above = found.above if options.is_groom(groom) else UP
        order = sets.Order(groom, scene, folder, kind, numbers, chance, frame, found.views, above, resume, overwrite)
        with talk.progress(len(numbers), options.preset_name(groom), each="view") as progress:
            warn = warner(progress, talk.quiet, heard=heard)
            for note in found.notes:
                warn(note)
            data = sets.make(order, threads, sets.Talk(progress.note, warn, progress.checked_step))
        made.append({"folder": str(folder), **data})
        talk.note(f"{folder}: {counted(len(data['views']), 'view')} in the layout {kind.name}")
    talk.data(made)


def _require_files(grooms: tuple[str, ...]) -> None:
    """Raise `UsageError` for files of strands that are not there, before hours of drawing the rest."""
    from ..exchange.files import files_of

    for groom in grooms:
        if options.is_groom(groom) and not files_of(Path(groom))[0].is_file():
            raise UsageError(f"{groom}: there is no such file; nothing was drawn")
