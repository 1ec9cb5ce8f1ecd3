"""Angles of the labels against a bank of Gabor filters that runs over the picture, as the projects' own scripts do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import dataset_kit as kit
import groom_file_kit


def wisps(path: Path, seed: int, slant: float, waves: float) -> Path:
    """Some 1,500 strands side by side that fall at a slant, in waves."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 1, 40)[:, None]
    strands = []
    for _ in range(1500):
        root = np.array([rng.uniform(-0.9, 0.9), 0.9, rng.uniform(-0.1, 0.1)])
        line = np.array([[0.0, -1.8, 0.0]]) * t
        line[:, 0] += waves * np.sin(5 * t[:, 0] + 2 * root[0]) + 0.01 * rng.normal()
        strands.append((root + line).astype(np.float64))
    angle = np.radians(slant)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    return groom_file_kit.write(path, [(one @ turn.T).astype(np.float32) for one in strands])


@pytest.mark.parametrize(("slant", "waves"), [
    (35, 0.12), (80, 0.0),
])  # fmt: skip
def test_angles_are_those_that_the_filters_find(slant: float, waves: float, tmp_path: Path) -> None:
    path = wisps(tmp_path / "wisps.data", 3, slant, waves)
    look = {"material.width": 0.004, "material.colour_variation": 0.9, "camera.position": (0, 0, 3)}
    kit.run(kit.order(path, tmp_path, "gaussianhaircut", size=(192, 192), scene=look))
    angles = kit.picture(tmp_path / "orientations" / "angles" / "0000.png")
    hair = kit.picture(tmp_path / "masks" / "hair" / "0000.png") > 127
    found, _ = kit.gabor(kit.picture(tmp_path / "images" / "0000.png"))
    inside = hair.copy()
    for axis in (0, 1):
        for step in range(-8, 9):  # where a filter sees nothing but hair
            inside &= np.roll(hair, step, axis)
    assert inside.sum() > 2000
    off = kit.apart(angles, found)[inside]
    mirrored = kit.apart(180 - angles.astype(float), found)[inside]
    upright = kit.apart(90 + angles.astype(float), found)[inside]
    print(f"slant {slant}: median {np.median(off):.2f} degrees, of {inside.sum()} pixels")
    assert np.median(off) < 3
    assert np.median(upright) > 60
    assert np.median(mirrored) > 15
