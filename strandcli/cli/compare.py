"""`strandcli compare`: two images against each other."""

from __future__ import annotations

from pathlib import Path

import click

from ..errors import MismatchError, UsageError
from . import options
from .progress import Talk, say


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
@click.option("--flip", "perceived", is_flag=True, help="Also measure ꟻLIP: how far they are apart to the eye, 0 to 1.")
@options.brief
def command(
    first: Path, second: Path, output: Path | None, threshold: int, allow: float, rmse: float | None, perceived: bool,
    talk: Talk,
) -> None:  # fmt: skip
    """Compare the pixels of two images A and B, or of the frames in two folders; ends with exit code 3 if they differ
    by more than allowed."""
    from ..output.compare import compare_files, difference_image, write_image
    from ..output.flip import mean_flip

    if output is not None:
        options.require_png(output)
    folders = _are_folders(first, second)
    if folders and (output is not None or talk.as_json):
        raise UsageError("-o and --json are for two images: name one frame of each folder")
    for a, b in _frames(first, second) if folders else [(first, second)]:
        found, one, two, note = compare_files(a, b, threshold)
        if note:
            talk.note(note)
        if output is not None:
            write_image(output, difference_image(one, two))
        seen = {"flip": mean_flip(one, two)} if perceived else {}
        over = 100 * found.over_fraction > allow
        if talk.as_json:
            talk.data({"a": str(a), "b": str(b), **found.as_dict(), **seen})
        elif not talk.quiet:
            if not over:  # else the error tells
                say(f"{a.name}: {found}" if folders else str(found))
            if not found.equal and found.psnr_db is not None:
                say(f"PSNR {found.psnr_db:.1f} dB")
            if perceived:
                say(f"ꟻLIP {seen['flip']:.4f}")
        if over:
            raise MismatchError(f"{a} and {b} differ: {found}")
        if rmse is not None and found.rmse > rmse:
            raise MismatchError(f"{a} and {b} differ: RMSE {found.rmse:.3g}/255 is above {rmse:g}")


def _are_folders(first: Path, second: Path) -> bool:
    """Whether folders are compared, not images. Raises `UsageError` for one that is missing, and for one of each."""
    for one in (first, second):
        if not one.exists():
            raise UsageError(f"{one}: no such image or folder")
    if first.is_dir() != second.is_dir():
        folder, image = (first, second) if first.is_dir() else (second, first)
        raise UsageError(f"{folder}: is a folder, and {image} an image; name two images or two folders")
    return first.is_dir()


def _frames(first: Path, second: Path) -> list[tuple[Path, Path]]:
    """The frames of two folders in pairs. Raises `MismatchError` for a frame that is in one of them alone, and
    `UsageError` where there are none."""
    names = [{path.name for path in folder.glob("frame_*.png")} for folder in (first, second)]
    if not names[0] | names[1]:
        raise UsageError(f"{first} and {second}: neither has a frame_*.png")
    for has, lacks, missing in ((first, second, names[0] - names[1]), (second, first, names[1] - names[0])):
        if missing:
            more = f" and {len(missing) - 1:,} more" if len(missing) > 1 else ""
            raise MismatchError(f"{lacks}: has no {min(missing)}{more}, as {has} has")
    return [(first / name, second / name) for name in sorted(names[0])]
