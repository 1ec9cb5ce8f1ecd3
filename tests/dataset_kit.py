"""Small data sets of made-up strands, and a bank of Gabor filters of its own."""

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
from strandcli.dataset.order import layout_of, scene_for
from strandcli.dataset.run import Order, Talk, make
from strandcli.dataset.views import Chance

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


def gabor(image: npt.NDArray[np.uint8], step: int = 1) -> tuple[Floats, Floats]:
    """Angle in degrees and variance in radians² of every pixel, (height, width), by filters every ``step`` degrees.

    Filters are waves of .23 a pixel under a bell of deviations 1.8 across the wave and 2.4 along its crests, after a
    difference of bells of deviations .4 and 10; by Fourier transforms, so that borders wrap.
    """
    grey = image @ np.array([0.2989, 0.5870, 0.1140])
    height, width = grey.shape
    v, u = np.meshgrid(2 * np.pi * np.fft.fftfreq(height), 2 * np.pi * np.fft.fftfreq(width), indexing="ij")
    square = u * u + v * v
    bells = np.exp(-0.5 * 0.4**2 * square) - np.exp(-0.5 * 10**2 * square)
    spectrum = np.fft.fft2(grey) * bells
    angles = np.radians(np.arange(0, 180, step))
    answers = []
    for angle in angles:
        # crests run along (sin, cos), right and down; the wave goes across them
        across = u * math.cos(angle) - v * math.sin(angle)
        along = u * math.sin(angle) + v * math.cos(angle)
        wave = 2 * np.pi * 0.23
        bell = sum(np.exp(-0.5 * (1.8 * (across - sign * wave)) ** 2 - 0.5 * (2.4 * along) ** 2) for sign in (-1, 1))
        answers.append(np.abs(np.fft.ifft2(spectrum * bell).real))
    every = np.stack(answers)
    best = angles[every.argmax(0)]
    apart = np.abs(best - angles[:, None, None])
    apart = np.minimum(apart, np.pi - apart)
    return np.degrees(best), (apart**2 * every).sum(0) / every.sum(0)


def apart(a: npt.ArrayLike, b: npt.ArrayLike) -> Floats:
    """Degrees between lines at angles a and b."""
    found = np.abs(np.subtract(a, b, dtype=np.float64)) % 180
    return np.asarray(np.minimum(found, 180 - found))
