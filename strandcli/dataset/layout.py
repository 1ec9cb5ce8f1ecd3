"""What a layout of data sets is: the files of a view, and those of all views together."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..cameras.pinhole import Floats, Pinhole
from ..output import png
from .labels import Labels

Pieces = Iterable[bytes]


@dataclass(frozen=True, eq=False)
class Cloud:
    """Strands as a whole, for layouts that want a scene's size or some of its points."""

    points: Floats
    """(k, 3) metres; some points of the strands."""
    middle: Floats
    """(3,) of the box about all."""
    radius: float
    """Metres; of a ball about the middle that holds all."""


class Layout:
    """A layout; one of another package has the same names. A driver overrides what differs from this.

    `paths` of a view hold ``{}`` for its name, and `encode` gives the contents in the same order. Every file is written
    whole or not at all, and those of a view before it counts as done.
    """

    name = ""
    perspective = True
    """Else views are orthographic."""
    square = False
    """Whether only square pictures are read."""
    centred = False
    """Whether the principal point is taken to be the middle of the picture."""
    own_light = False
    """Whether each view has a light and colour of its own; else a set has one, as photographs of a person have."""
    size = (512, 512)
    paths: tuple[str, ...] = ()

    def encode(self, labels: Labels) -> Sequence[Pieces]:
        """The files of a view."""
        raise NotImplementedError

    def index(self, views: Sequence[Pinhole], cloud: Cloud) -> dict[str, Pieces]:
        """The files of all views together, by their paths."""
        raise NotImplementedError

    def links(self) -> dict[str, str]:
        """Folders under a second name, which point to the first."""
        return {}


def mask_png(mask: NDArray[np.bool_]) -> list[bytes]:
    """A mask as a PNG of one channel, 0 and 255."""
    return png.encode(np.where(mask, np.uint8(255), np.uint8(0)))


def npy(array: NDArray[Any]) -> list[bytes]:
    """An array as a .npy file."""
    file = io.BytesIO()
    np.lib.format.write_array(file, np.ascontiguousarray(array), allow_pickle=False)
    return [file.getvalue()]
