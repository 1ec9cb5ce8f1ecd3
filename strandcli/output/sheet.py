"""A contact sheet: many images in rows on one, each with its label beneath."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import RefusedError, UsageError
from . import png
from .compare import write_image
from .png import Rgb, over

KINDS = (".png", ".jpg", ".jpeg", ".webp", ".gif")
GAP = 8
PAPER: Rgb = (24, 25, 28)
INK = (220, 221, 224)
LARGEST = 32_768
MOST_BYTES = 2_000_000_000


@dataclass(frozen=True, slots=True)
class Cell:
    """One image of a sheet and the words beneath it."""

    path: Path
    label: str


def gather(sources: Sequence[Path], leave_out: Path | None = None) -> list[Cell]:
    """The cells for files and folders, in the order given.

    A single folder stands for its images in the order of their names; among several sources a folder of frames stands
    for its last one; and one that holds folders instead, such as out/figures, for the last image of each of these.
    Files are labelled by their names, behind the folder's where two have the same; folders of frames by theirs.
    ``leave_out`` is the sheet itself. Raises ``UsageError`` for a source without images.
    """
    cells: list[Cell] = []
    for source in sources:
        if source.is_dir():
            found = [Cell(path, path.stem) for path in _images(source, leave_out)]
            if found and (len(sources) > 1 or len(found) == 1) and found[-1].path.stem.startswith("frame_"):
                found = [Cell(found[-1].path, source.name)]
            if not found:
                inner = [(folder, _images(folder, leave_out)) for folder in sorted(source.iterdir()) if folder.is_dir()]
                found = [Cell(paths[-1], folder.name) for folder, paths in inner if paths]
            if not found:
                raise UsageError(f"{source}: has no images ({', '.join(KINDS)}), and neither do its folders")
            cells += found
        elif source.is_file():
            cells.append(Cell(source, source.stem))
        else:
            raise UsageError(f"{source}: no such file or folder")
    labels = Counter(cell.label for cell in cells)
    twins = [labels[one.label] > 1 and one.label == one.path.stem for one in cells]
    return [replace(one, label=f"{one.path.parent.name}/{one.label}") if twin else one
            for one, twin in zip(cells, twins, strict=True)]  # fmt: skip


def _images(folder: Path, leave_out: Path | None) -> list[Path]:
    skip = leave_out.resolve() if leave_out is not None else None
    return [
        path
        for path in sorted(folder.iterdir())
        if path.suffix.lower() in KINDS
        and path.is_file()
        and not path.name.startswith((".", "animation."))
        and path.resolve() != skip
    ]


def make_sheet(cells: Sequence[Cell], columns: int, width: int, paper: Rgb = PAPER) -> png.Pixels:
    """The sheet as uint8, (height, width, 3). Images wider than ``width`` are scaled down, none is scaled up; those
    with alpha are over the colour ``paper``.

    Raises ``UsageError`` for an image that cannot be read and ``RefusedError`` for a sheet that is too big.
    """
    from PIL import Image, ImageDraw, ImageFont

    columns = min(columns, len(cells))
    pictures = [_fit(cell.path, width, paper) for cell in cells]
    text = max(12, min(20, width // 16))
    font = ImageFont.load_default(size=text)
    cell_width = max(picture.width for picture in pictures)
    rows = [pictures[start : start + columns] for start in range(0, len(pictures), columns)]
    heights = [max(picture.height for picture in row) + text + GAP for row in rows]
    total = (GAP + columns * (cell_width + GAP), GAP + sum(heights) + GAP * len(rows))
    if max(total) > LARGEST or 3 * total[0] * total[1] > MOST_BYTES:
        raise RefusedError(f"a sheet of {total[0]}x{total[1]} pixels is too big; choose a smaller --width")
    sheet = Image.new("RGB", total, PAPER)
    draw = ImageDraw.Draw(sheet)
    top = GAP
    for row_number, row in enumerate(rows):
        for column, picture in enumerate(row):
            left = GAP + column * (cell_width + GAP)
            sheet.paste(picture, (left + (cell_width - picture.width) // 2, top))
            label = _shorten(cells[row_number * columns + column].label, font, cell_width)
            place = (left + cell_width // 2, top + heights[row_number] - text - GAP // 2)
            draw.text(place, label, fill=INK, font=font, anchor="ma")
        top += heights[row_number] + GAP
    return np.asarray(sheet)


def write_sheet(path: Path, cells: Sequence[Cell], columns: int, width: int, paper: Rgb = PAPER) -> tuple[int, int]:
    """Write the sheet as PNG, whole or not at all; returns its (width, height). ``paper``: as in `make_sheet`."""
    sheet = make_sheet(cells, columns, width, paper)
    write_image(path, sheet)
    return sheet.shape[1], sheet.shape[0]


def _fit(path: Path, width: int, paper: Rgb) -> Any:
    from PIL import Image

    picture = Image.fromarray(over(np.rint(png.read_samples(path)).astype(np.uint8), paper))
    if picture.width <= width:
        return picture
    height = max(1, round(picture.height * width / picture.width))
    return picture.resize((width, height), Image.Resampling.LANCZOS)


def _shorten(label: str, font: Any, width: int) -> str:
    """The label, or as much of it as fits."""
    if font.getlength(label) <= width:
        return label
    while label and font.getlength(label + "…") > width:
        label = label[:-1]
    return label + "…"
