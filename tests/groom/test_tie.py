"""Tied strands: shortest ways over the emitter, hair that keeps its volume, whatever order strands stand in."""

from __future__ import annotations

import dataclasses
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest

from strand_kit import scene_of
from strandcli.groom.blocks import arranged
from strandcli.groom.combed import Combed
from strandcli.groom.emit import emit
from strandcli.groom.tie import chart_of
from strandcli.scene.model import Emitter, Scene, SphereShape, Tie

SPHERE = SphereShape(radius=0.1, cap=110)
TIE = Tie(position=(0.01, 0.09, -0.04), radius=0.016, lift=0.012)
SCENE = """
emitter: {strands: 300, particles: 6, length: 0.3, shape: {kind: sphere, radius: 0.1, cap: 110},
  tie: {position: [0.01, 0.09, -0.04], radius: 0.016, lift: 0.012},
  keys: [{time: 0, rotation: [10, 0, 0]}, {time: 1, position: [0.1, 0.2, 0.3], rotation: [40, 120, 30], ease: linear}]}
rules: [emitter_motion, gravity, elasticity]
"""


def emitter_of(**settings: Any) -> Emitter:
    return dataclasses.replace(Emitter(strands=4000, length=0.3, shape=SPHERE, tie=TIE), **settings)


def combed(emitter: Emitter, scene: Scene | None = None) -> np.ndarray:
    """(strands, 1 + TIED, 3) in the emitter's frame, the point before the root first."""
    scene = dataclasses.replace(scene or Scene(), emitter=emitter)
    return Combed(scene, emit(emitter, scene.seed)).points.astype(np.float64)


def test_a_bundle_is_as_wide_as_asked_and_evenly_full_along_each_direction() -> None:
    """In each direction from the tie, whose own rim may be near or far, strands are even by area."""
    emitter = emitter_of(strands=40_000)
    groom, chart, tie = emit(emitter, 0), chart_of(emitter), emitter.tie
    assert tie is not None
    across = groom.roots.astype(float) - chart.foot - tie.lift * chart.normal
    assert np.abs(across @ chart.normal).max() < 1e-7
    away = np.linalg.norm(across, axis=1) / tie.radius
    assert 0.98 < away.max() <= 1 + 1e-5
    around = np.arctan2(across @ np.cross(chart.normal, [1.0, 0, 0]), across[:, 0])
    for begin in np.linspace(-np.pi, np.pi, 9)[:-1]:
        here = away[(around >= begin) & (around < begin + np.pi / 4)]
        assert (here < 0.5).mean() == pytest.approx(0.25, abs=0.025)


def test_slack_is_of_few_strands_and_never_more_than_asked() -> None:
    tight, loose = combed(emitter_of()), combed(emitter_of(tie=dataclasses.replace(TIE, slack=0.01)))
    off = np.linalg.norm(loose - tight, axis=2).max(1)
    assert 0.008 < off.max() < 0.01 * np.sqrt(2) * 1.02
    assert np.median(off) < 0.001
    np.testing.assert_array_equal(loose[:, 1], tight[:, 1])


def test_the_combed_parts_of_many_are_those_of_each() -> None:
    """Whatever order they stand in, and however many are combed at once."""
    scene = scene_of(SCENE.replace("lift: 0.012", "lift: 0.012, slack: 0.01, spread: 20"))
    groom = emit(scene.emitter, scene.seed)
    points = Combed(scene, groom).points
    near = arranged(groom)
    assert near.places is not None
    assert not np.array_equal(near.places, np.arange(300))
    np.testing.assert_array_equal(Combed(scene, near).points, points[near.places])
    with patch("strandcli.groom.combed.BATCH", 77):
        np.testing.assert_array_equal(Combed(scene, groom).points, points)
