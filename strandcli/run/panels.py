"""Pictures of several scenes side by side, each with its label underneath."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..scene.model import Scene
from .frame import Frame

GAP = 4
INK = (225, 225, 225)
PAPER = (24, 25, 28)


def side_by_side(scene: Scene, parts: Sequence[Iterator[Frame]]) -> Iterator[Frame]:
    """Frames of all panels, joined; times and counts add up, of errors the greatest counts."""
    for frames in zip(*parts, strict=True):
        images = [frame.image for frame in frames if frame.image is not None]
        image = join(images, [panel.label for panel in scene.panels]) if images else None
        report = {
            "frame": frames[0].number,
            "seconds": merged([frame.report["seconds"] for frame in frames], sum),
            "counts": merged([frame.report["counts"] for frame in frames], sum),
            "error": merged([frame.report["error"] for frame in frames], max),
        }
        yield Frame(frames[0].number, image, None, report)


def join(images: Sequence[NDArray[np.uint8]], labels: Sequence[str]) -> NDArray[np.uint8]:
    """Images from left to right with a gap between, (height + strip, width, 3); no strip where no label has text. Where
    some have alpha, so has the whole, and gaps and labels are opaque."""
    from PIL import Image, ImageDraw, ImageFont

    height = max(image.shape[0] for image in images)
    text = max(12, height // 28)
    strip = 2 * text if any(labels) else 0
    width = sum(image.shape[1] for image in images) + GAP * (len(images) - 1)
    mode = "RGBA" if any(image.shape[2] == 4 for image in images) else "RGB"
    sheet = Image.new(mode, (width, height + strip), PAPER)
    pen = ImageDraw.Draw(sheet)
    left = 0
    for image, label in zip(images, labels, strict=True):
        font = ImageFont.load_default(fitting_size(label, text, image.shape[1]))
        sheet.paste(Image.fromarray(image).convert(mode), (left, 0))
        if strip:
            pen.text((left + image.shape[1] / 2, height + strip / 2), label, INK, font, anchor="mm")
        left += image.shape[1] + GAP
    return np.asarray(sheet)


def fitting_size(label: str, size: int, width: int) -> int:
    """The height in pixels at which a label is no wider than ``width``: at most ``size``, at least 6."""
    from PIL import ImageFont

    while size > 6 and ImageFont.load_default(size).getlength(label) > width:
        size -= 1
    return size


def merged(parts: Sequence[dict[str, Any]], join: Any) -> dict[str, Any]:
    """What joins the values of each key, those that are not None; None where all are None."""
    keys = dict.fromkeys(key for part in parts for key in part)
    known = {key: [part[key] for part in parts if part.get(key) is not None] for key in keys}
    return {key: join(values) if values else None for key, values in known.items()}
