"""Small data sets of made-up strands."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

import groom_file_kit as kit
from strandcli.dataset.run import Order, Talk, make
from strandcli.dataset.views import Chance, layout_of, scene_for

Floats = npt.NDArray[np.float64]
SIZE = (64, 64)
AHEAD = {"azimuth": (0.0, 0.0), "elevation": (0.0, 0.0), "light": "scene", "colour": "scene"}
"""All views from straight ahead, along −z, and nothing by chance but how large the strands are seen."""


def order(path: Path, folder: Path, layout: str, views: Sequence[int] = (0,), **given: Any) -> Order:
    """A data set of a file of strands, seen from z; ``scene``: settings of it; others are of `Chance` and `Order`."""
    kind = layout_of(layout)
    settings = {"camera.position": (0, 0, 3), "camera.target": (0, 0, 0), **given.pop("scene", {})}
    size = given.pop("size", SIZE)
    scene = scene_for(kit.scene(path, **settings), kind, size, 1)
    chance = Chance(given.pop("seed", 1), "groom", **{key: given.pop(key, AHEAD[key]) for key in AHEAD})
    return Order("groom", scene, folder, kind, views, chance, **given)


def run(asked: Order, talk: Talk | None = None) -> dict[str, Any]:
    """Make a data set on all threads."""
    return make(asked, None, talk or Talk())


def straight(path: Path, lines: Sequence[tuple[Sequence[float], Sequence[float]]]) -> Path:
    """A file of straight strands, each from a root to a tip."""
    t = np.linspace(0, 1, 9)[:, None]
    return kit.write(path, [(np.array(a) + t * np.subtract(b, a)).astype(np.float32) for a, b in lines])


def slanted(degrees: float, depth: float = 0.0, length: float = 1.0) -> tuple[list[float], list[float]]:
    """Root and tip of a strand about the origin that points so many degrees to the right from straight down."""
    way = 0.5 * length * np.array([math.sin(math.radians(degrees)), -math.cos(math.radians(degrees)), 0.0])
    middle = np.array([0.0, 0.0, depth])
    return list(middle - way), list(middle + way)


def picture(path: Path) -> npt.NDArray[np.uint8]:
    """The pixels of a PNG as they are in the file."""
    with Image.open(path) as image:
        return np.array(image)


def manifest(folder: Path) -> dict[str, Any]:
    """What dataset.json holds."""
    return dict(json.loads((folder / "dataset.json").read_text()))


def apart(a: npt.ArrayLike, b: npt.ArrayLike) -> Floats:
    """Degrees between lines at angles a and b."""
    found = np.abs(np.subtract(a, b, dtype=np.float64)) % 180
    return np.asarray(np.minimum(found, 180 - found))
