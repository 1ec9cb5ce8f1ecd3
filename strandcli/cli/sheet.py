"""`strandcli sheet`: many images on one."""

from __future__ import annotations

from pathlib import Path

import click

from ..common.counted import counted
from . import options
from .progress import say
from .values import COLOUR


@click.command()
@click.argument("sources", nargs=-1, required=True, type=options.PathType(), metavar="DIR_OR_FILE...")
@click.option("-o", "--output", type=options.PathType(), required=True, metavar="FILE", help="The sheet (PNG).")
@click.option("--columns", type=options.Whole(1, 1000), default=4, show_default=True, metavar="N", help="Images a row.")
@click.option(
    "--width", type=options.Whole(16, 32_768), default=400, show_default=True, metavar="PX",
    help="Images wider than this are scaled down.",
)  # fmt: skip
@click.option(
    "--over", type=COLOUR, metavar="COLOUR",
    help="Colour under images with alpha: white, '#rrggbb'.  [default: the sheet's own]",
)  # fmt: skip
@options.overwrite
@options.quiet
def command(
    sources: tuple[Path, ...], output: Path, columns: int, width: int, over: tuple[int, int, int] | None,
    overwrite: bool, quiet: bool,
) -> None:  # fmt: skip
    """Put images on one labelled contact sheet.

    A single folder gives its images by name, several folders of frames the last frame of each, and a folder of such
    folders, like out/figures, the same.
    """
    from ..output.files import prepare_folder
    from ..output.sheet import PAPER, gather, write_sheet

    options.require_png(output)
    options.refuse_existing(output, overwrite)
    cells = gather(sources, leave_out=output)
    prepare_folder(output.parent, 0)
    wide, high = write_sheet(output, cells, columns, width, over or PAPER)
    if not quiet:
        say(f"{output}: {counted(len(cells), 'image')}, {wide}x{high}", err=True)
