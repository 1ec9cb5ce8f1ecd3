"""Hair that is too short for the tie: how many, where, how long, and that it is drawn in place of what is tied."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from scene_kit import complaint
from strand_kit import scene_of
from strandcli.draw.common.scratch import Scratch
from strandcli.groom.blocks import pack, unpack
from strandcli.groom.combed import Combed
from strandcli.groom.emit import emit
from strandcli.groom.record import Groom
from strandcli.groom.tie import OFF, chart_of, chosen, wisps
from strandcli.scene.model import Emitter, Scene, SphereShape, Tie
from strandcli.scene.model.emitter import TIED
from strandcli.scene.motion import emitter_pose

LENGTH = 0.02
TIE = Tie(position=(0.01, 0.09, -0.04), radius=0.016, lift=0.012, wisps=0.6, wisp_length=LENGTH)
BALL = SphereShape(radius=0.1, cap=110)
ROWS = 30
SCENE = """
emitter: {strands: 300, particles: 6, length: 0.3, shape: {kind: sphere, radius: 0.1, cap: 110},
  tie: {position: [0.01, 0.09, -0.04], radius: 0.016, lift: 0.012, wisps: %g},
  keys: [{time: 0, rotation: [10, 0, 0]}, {time: 1, position: [0.1, 0.2, 0.3], rotation: [40, 120, 30]}]}
rules: [emitter_motion, gravity, elasticity]
"""


def made() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where wisps grow, (K, 3), and where they are, (K, ROWS, 3)."""
    emitter = Emitter(strands=4000, length=0.3, shape=BALL, tie=TIE)
    groom = emit(emitter, 0)
    assert groom.grown is not None
    rng = np.random.default_rng(1)
    roots = groom.grown[chosen(emitter, groom, rng.random(4000))]
    lots = rng.random((len(roots), 4))
    return roots, wisps(emitter, roots, lots, ROWS, lambda points, _: np.zeros(len(points))).astype(float)


def test_they_are_as_many_as_asked_at_the_rim_and_fewer_by_the_exponential_law() -> None:
    emitter = Emitter(strands=400_000, length=0.3, shape=BALL, tie=TIE)
    groom = emit(emitter, 0)
    assert groom.grown is not None
    short = np.zeros(emitter.strands, bool)
    short[chosen(emitter, groom, np.random.default_rng(0).random(emitter.strands))] = True
    chart = chart_of(emitter)
    d, ways = chart.polar(groom.grown)
    inside = chart.rim(ways) - d
    for k in range(5):
        here = (inside >= 0.01 * k) & (inside < 0.01 * (k + 1))
        assert short[here].mean() == pytest.approx(np.mean(0.6 * np.exp(-inside[here] / LENGTH)), rel=0.06)


def test_they_never_go_into_what_bears_them() -> None:
    roots, points = made()
    assert len(roots) > 100
    above = np.linalg.norm(points[:, 1:], axis=-1) - BALL.radius
    assert above.min() > -1e-7
    assert above.max() <= OFF * LENGTH


def joined(scene: Scene, groom: Groom, at: float, ids: NDArray[np.int32] | None = None) -> NDArray[np.float64]:
    """(strands, rows, 3) at a time, with something that hangs from the tie; of those called ``ids`` or all."""
    hanging = np.random.default_rng(0).normal(size=(300, 7, 3)).astype(np.float32)
    some = hanging if ids is None else hanging[ids]
    return unpack(Combed(scene, groom).join(pack(some), at, len(some), Scratch(), ids), len(some)).astype(float)


def test_they_are_drawn_in_place_of_what_is_tied_and_move_with_the_emitter() -> None:
    scene, none = scene_of(SCENE % 0.7), scene_of(SCENE % 0)
    groom = emit(scene.emitter, scene.seed)
    short = Combed(scene, groom).short
    assert 20 < len(short) < 150
    assert len(Combed(none, groom).short) == 0
    rest = np.setdiff1d(np.arange(300), short)
    now, tied = joined(scene, groom, 1.0), joined(none, groom, 1.0)
    np.testing.assert_array_equal(now[rest], tied[rest])
    rotation, shift = (np.array(part) for part in emitter_pose(scene.emitter, 1.0))
    assert groom.grown is not None
    np.testing.assert_allclose((now[short, 1] - shift) @ rotation, groom.grown[short], atol=1e-7)
    rotation, shift = (np.array(part) for part in emitter_pose(scene.emitter, 0.0))
    first = (joined(scene, groom, 0.0) - shift) @ rotation
    rotation, shift = (np.array(part) for part in emitter_pose(scene.emitter, 1.0))
    np.testing.assert_allclose((now[short] - shift) @ rotation, first[short], atol=1e-7)
    assert now.shape[1] == 1 + TIED + 6
    assert np.linalg.norm(np.diff(first[short, 1:], axis=1), axis=2).sum(1).max() < 1.3 * scene.emitter.tie.wisp_length


@pytest.mark.parametrize("text", ["wisps: 1.5", "wisp_length: 0"])
def test_refused(text: str) -> None:
    assert f"emitter.tie.{text.split(':')[0]}: must be a number" in complaint(f"emitter: {{tie: {{{text}}}}}")
