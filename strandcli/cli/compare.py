"""`strandcli compare`: two images against each other."""

from __future__ import annotations

from pathlib import Path

import click

from ..errors import MismatchError
from . import options
from .say import say


@click.command()
@click.argument("first", type=options.PathType(), metavar="A")
@click.argument("second", type=options.PathType(), metavar="B")
@click.option("-o", "--output", type=options.PathType(), metavar="FILE", help="Write a difference image (PNG).")
@click.option(
    "--threshold", type=options.Whole(0, 255), default=0, show_default=True, metavar="N",
    help="Count pixels that differ by more than N/255 in some channel.",
)  # fmt: skip
@click.option(
    "--allow", type=click.FloatRange(0, 100), default=0.0, show_default=True, metavar="PERCENT",
    help="Share of pixels that may be counted before it is a mismatch.",
)  # fmt: skip
@click.option("--rmse", type=click.FloatRange(0, 255), metavar="X", help="Greatest RMSE, of 255.  [default: no limit]")
@options.as_json
@options.quiet
@options.debug
def command(
    first: Path,
    second: Path,
    output: Path | None,
    threshold: int,
    allow: float,
    rmse: float | None,
    as_json: bool,
    quiet: bool,
) -> None:
    """Compare the pixels of two images A and B; ends with exit code 3 if they differ by more than allowed."""
    from ..output.compare import compare_files, difference_image, write_image

    if output is not None:
        options.require_png(output)
    found, one, two = compare_files(first, second, threshold)
    if output is not None:
        write_image(output, difference_image(one, two))
    if as_json:
        options.print_json({"a": str(first), "b": str(second), **found.as_dict()})
    elif not quiet:
        say(str(found))
        if not found.equal and found.psnr_db is not None:
            say(f"PSNR {found.psnr_db:.1f} dB")
    if 100 * found.over_fraction > allow:
        raise MismatchError(f"{first} and {second} differ: {found}")
    if rmse is not None and found.rmse > rmse:
        raise MismatchError(f"{first} and {second} differ: RMSE {found.rmse:.3g}/255 is above {rmse:g}")
