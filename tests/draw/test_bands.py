"""Bands of rows against the same picture drawn at once."""

from __future__ import annotations

import numpy as np
import pytest

from strand_kit import frames_of, scene_of
from strandcli.draw import bands

SCENE = """
emitter: {strands: 300, particles: 12, length: 0.7, shape: {kind: sphere, radius: 0.5}}
camera: {position: [0, 0.4, 3], target: [0, 0, 0], fov: 40}
image: {size: [61, 47], resolver: sorted, supersample: 2, aovs: [strand_id, depth, mask, tangent, linear], %s}
material: {width: 0.004, taper: 0.7}
curves: {%s}
solids: [{kind: sphere, radius: 0.5, colour: [0.5, 0.4, 0.3]}, {kind: plane, position: [0, -1, 0]}]
ambient: [0.2, 0.2, 0.2]
ambient_occlusion: {cells: 4000}
lights: [{kind: directional, direction: [-1, -1, -1], intensity: 2, size: 3, shadow: {model: opacity, size: 64}}]
time: {frames: 2}
rules: {gravity: {}, stiffness: {}}
"""
CURVES = [
    "mode: adaptive, tolerance: 0.02", "mode: thinned, tolerance: 0.3", "mode: fixed, level: 0", "mode: off",
    "mode: fixed, level: 2",
]  # fmt: skip


@pytest.mark.parametrize("curves", CURVES)
def test_a_picture_in_bands_is_the_same(curves: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = scene_of(SCENE % ("background: none" if "thinned" in curves else "haze: 9", curves))
    (whole,) = frames_of(scene, 2)
    cuts: list[list[tuple[int, int]]] = []
    monkeypatch.setattr("strandcli.draw.renderer.SORTED_POINTS", 0)
    for module in ("strandcli.draw.strand_batches", "strandcli.draw.bands"):
        monkeypatch.setattr(f"{module}.BAND_VERTICES", 150)
    cut = bands._cut
    monkeypatch.setattr(bands, "_cut", lambda *of: cuts.append(cut(*of)) or cuts[-1])
    (banded,) = frames_of(scene, 2)
    assert len(cuts[0]) > 3
    # a curve of equal pieces is lit at every vertex there, and at each second one otherwise
    most, some, other = (6, 0.2, 0.005) if curves.endswith("level: 2") else (1, 0.01, 0.0)
    apart = np.abs(banded.image.astype(int) - whole.image)
    assert apart.max() <= most
    assert (apart > 0).mean() < some
    for name in ("strand_id", "depth", "mask", "tangent"):
        assert np.mean(banded.aovs[name] != whole.aovs[name]) <= other
