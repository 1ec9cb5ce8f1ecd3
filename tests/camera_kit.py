"""Views by chance, and points that they see."""

from __future__ import annotations

import numpy as np

from strandcli.cameras.pinhole import Pinhole

POINTS = np.random.default_rng(7).uniform(-0.5, 0.5, (50, 3))


def view(seed: int, perspective: bool = True, size: tuple[int, int] = (64, 48), middle: bool = False) -> Pinhole:
    """A view of the points by chance, its principal point off the middle."""
    rng = np.random.default_rng(seed)
    ahead = rng.normal(size=3)
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, rng.normal(size=3))
    right /= np.linalg.norm(right)
    off = 0 if middle else 1
    centre = (size[0] / 2 + off * rng.uniform(-9, 9), size[1] / 2 + off * rng.uniform(-9, 9))
    eye = -rng.uniform(2, 5) * ahead + rng.uniform(-0.2, 0.2, 3)
    rotation = np.stack([right, np.cross(ahead, right), ahead])
    return Pinhole(f"{seed:04d}", *size, rng.uniform(30, 900), centre, rotation, eye, perspective)


VIEWS = [view(seed) for seed in range(6)]
