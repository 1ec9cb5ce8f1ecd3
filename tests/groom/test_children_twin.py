"""Children against a twin in double precision, one strand at a time, written from the formulas alone."""

from __future__ import annotations

import dataclasses
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from strand_kit import scene_of
from strandcli.draw.common.scratch import Scratch
from strandcli.groom.blocks import lanes, pack, unpack
from strandcli.groom.children import Children
from strandcli.groom.emit import emit
from strandcli.groom.family import Family
from strandcli.scene.model import Clump, Wave

SCENE = """
seed: 5
emitter: {strands: 60, particles: 8, length: 0.4, shape: {kind: disc, radius: 0.1}, jitter: 20}
children: {count: 5}
rules: []
"""
CLUMPS = (Clump(size=0.06, strength=0.7, shape=2.0), Clump(size=0.02, strength=0.9, stray=0.2))
WAVES = (Wave(radius=0.006, length=0.09, round=0.5), Wave(radius=0.003, length=0.05, disorder=1, share=0.4, onset=0.0))
TOWARD = 0.3


def unit(x: np.ndarray) -> np.ndarray:
    return np.asarray(x / np.linalg.norm(x))


def along_guides(family: Family, offsets: np.ndarray, i: int) -> np.ndarray:
    """The particles (m, 3) of child i along its guides, whose particles (G, m, 3) are told from their roots."""
    return np.asarray(family.roots[i] + np.tensordot(family.weights[i].astype(float), offsets[family.parents[i]], 1))


def path_of(family: Family, children: Children, offsets: np.ndarray, i: int, rest: float) -> np.ndarray:
    """Particles of child i, (m, 3), pulled to the centres of its clumps, with segments of length ``rest``."""
    m = offsets.shape[1]
    whole = along_guides(family, offsets, i)
    for level in reversed(range(len(family.middles))):
        pull = family.pulls[level, i] * np.linspace(0, 1, m) ** children.settings.clumps[level].shape
        whole = whole + pull[:, None] * (along_guides(family, offsets, int(family.middles[level, i])) - whole)
    places = float(family.shares[i]) * np.arange(m)
    target = np.stack([np.interp(places, np.arange(m), whole[:, c]) for c in range(3)], 1)
    path = [target[0]]
    for before, after in pairwise(target):
        t = unit(after - before)
        error = before - path[-1]
        path.append(path[-1] + rest * unit(t + TOWARD / rest * (error - (error @ t) * t)))
    return np.array(path)


def with_waves(family: Family, waves: Any, path: np.ndarray, i: int, rest: float) -> np.ndarray:
    """The path of child i, displaced by waves, with segments of length ``rest``."""
    m = len(path)
    across = family.across[i]
    before, out = path[0], [path[0]]
    for j in range(1, m):
        t = unit(path[min(j + 1, m - 1)] - path[j - 1])
        across = unit(across - (across @ t) * t)
        x = path[j]
        for number, wave in enumerate(waves):
            angle = float(family.phases[number, i]) + float(family.turns[number, i]) * rest * j
            size = float(family.radii[number, i]) * min(j / (m - 1) / max(wave.onset, 1e-30), 1.0)
            x = x + size * (np.cos(angle) * across + wave.round * np.sin(angle) * np.cross(t, across))
        out.append(out[-1] + rest * unit(x - before))
        before = x
    return np.array(out)


def poison() -> None:
    """Leave what is not a number in memory that was freed."""
    for size in range(200, 12_000, 400):
        np.full(size, np.nan, np.float32)


@pytest.mark.parametrize("clumps", [(), CLUMPS])
@pytest.mark.parametrize("waves", [(), WAVES])
def test_children_are_those_of_the_formulas(clumps: Any, waves: Any) -> None:
    scene = scene_of(SCENE)
    settings = dataclasses.replace(scene.children, clumps=clumps, waves=waves, cut=0.5)
    scene = dataclasses.replace(scene, children=settings)
    groom = emit(scene.emitter, scene.seed)
    children, n = Children(scene, groom), scene.emitter.particles
    lots = np.random.default_rng(2)
    rest = groom.lengths.astype(float) / (n - 1)
    along = groom.directions[:, None] + np.cumsum(lots.normal(0, 0.1, (60, n, 3)), 1)
    along = rest[:, None, None] * along / np.linalg.norm(along, axis=2, keepdims=True)
    guides = groom.roots[:, None] - along[:, :1] + np.concatenate([0 * along[:, :1], np.cumsum(along, 1)], 1)
    packed = pack(guides)
    poison()
    ids = children.select(packed)[1]
    drawn, lengths = children.grow(packed, lanes(rest[:, None]), 0.0, ids, Scratch())
    found, family = unpack(drawn, len(ids)).astype(float), children.family

    from strandcli.groom.kernels.children import refine

    m = (n - 1) * children.steps + 1
    fine = np.empty((60, -(-3 * (m + 1) // 16) * 16), np.float32)
    refine(packed, np.int64(children.steps), fine)
    offsets = fine[:, : 3 * (m + 1)].reshape(60, m + 1, 3).astype(float)
    ways = np.linalg.norm(np.diff(guides, axis=1), axis=2)[:, 1]
    for i in range(0, len(ids), 3):
        own = float(family.weights[i].astype(float) @ ways[family.parents[i]] * family.shares[i]) / children.steps
        assert lengths.reshape(-1)[i] == pytest.approx(own, rel=1e-5)
        path = path_of(family, children, offsets[:, 1:], i, own)
        if waves:
            path = with_waves(family, waves, path, i, own)
        np.testing.assert_allclose(found[i, 1:], path, atol=4e-6)
        back = family.weights[i].astype(float) @ offsets[family.parents[i], 0]
        np.testing.assert_allclose(found[i, 0], path[0] + own * unit(back), atol=4e-6)
