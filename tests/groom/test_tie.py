"""Tied strands: shortest ways over the emitter, hair that keeps its volume, out of what it lies over, carried rigidly;
and one line from root to tip for everything that draws."""

from __future__ import annotations

import dataclasses
from typing import Any
from unittest.mock import patch

import numba
import numpy as np
import pytest

from strand_kit import scene_of
from strandcli.groom.arrange import arranged
from strandcli.groom.combed import Combed
from strandcli.groom.emit import emit
from strandcli.groom.kernels.combed import lift
from strandcli.groom.tie import chart_of
from strandcli.scene.model import DiscShape, Emitter, PlaneShape, Scene, SphereShape, Tie
from strandcli.scene.model.emitter import TIED
from strandcli.scene.motion import emitter_pose
from strandcli.solids.shapes import capsule

SPHERE = SphereShape(radius=0.1, cap=110)
AXIS = slice(capsule.AXIS_X, capsule.AXIS_Z + 1)
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


def test_ways_over_a_sphere_are_great_circles_of_the_shortest_length() -> None:
    """A bundle so thin that hair has no height: a way is then on the sphere, in the plane of root, tie and centre."""
    emitter = emitter_of(tie=dataclasses.replace(TIE, radius=1e-6, lift=0.0))
    groom, points = emit(emitter, 0), combed(emitter)[:, 1:]
    assert groom.grown is not None
    foot = np.array(TIE.position) / np.linalg.norm(TIE.position)
    np.testing.assert_allclose(points[:, 0], groom.grown, atol=1e-8)
    np.testing.assert_allclose(groom.roots, np.broadcast_to(0.1 * foot, groom.roots.shape), atol=2e-6)
    planes = np.cross(groom.grown, foot)
    planes /= np.linalg.norm(planes, axis=1, keepdims=True)
    assert np.abs((points * planes[:, None]).sum(2)).max() < 1e-6
    # as far as the last turn, which is so small here that only half the way of the nearest is in it
    np.testing.assert_allclose(np.linalg.norm(points[:, :14], axis=2), 0.1, atol=1e-6)
    angles = np.arccos(np.clip((points[:, :14] @ foot) / np.linalg.norm(points[:, :14], axis=2), -1, 1))
    passed = np.arccos(np.clip((points[:, :13] * points[:, 1:14]).sum(2) / 0.01, -1, 1)).sum(1)
    np.testing.assert_allclose(passed, angles[:, 0] - angles[:, -1], atol=2e-3)
    assert (np.diff(angles, axis=1) < 0).all()


@pytest.mark.parametrize("shape", [DiscShape(radius=0.1), PlaneShape(width=0.3, depth=0.2)])
def test_ways_over_a_plane_are_straight(shape: Any) -> None:
    emitter = emitter_of(shape=shape, tie=Tie(position=(0.03, 5.0, -0.02), radius=1e-6, lift=0.0))
    points = combed(emitter)[:, 1:]
    to = np.array([0.03, 0.0, -0.02]) - points[:, 0]
    off = np.cross(points - points[:, :1], (to / np.linalg.norm(to, axis=1, keepdims=True))[:, None])
    assert np.linalg.norm(off, axis=2).max() < 2e-6


@pytest.mark.parametrize(
    "emitter",
    [
        emitter_of(strands=40_000),
        emitter_of(strands=40_000, shape=SphereShape(radius=0.1)),
        emitter_of(strands=40_000, shape=PlaneShape(width=0.3, depth=0.2), tie=dataclasses.replace(TIE, radius=0.01)),
        emitter_of(strands=40_000, shape=DiscShape(radius=0.1), tie=dataclasses.replace(TIE, radius=0.01)),
    ],
)
def test_a_bundle_is_as_wide_as_asked_and_evenly_full_along_each_direction(emitter: Emitter) -> None:
    """In each direction from the tie, whose own rim may be near or far, strands are even by area."""
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


def test_hair_keeps_its_volume_and_lies_on_what_is_rooted_nearer() -> None:
    """All round, at any distance from the tie, strands are from the surface up to the thickness that what crosses there
    has in the bundle: height · arc over all directions is the bundle's area times the share rooted farther."""
    emitter = emitter_of(strands=20_000, shape=SphereShape(radius=0.1, cap=110), tie=Tie(position=(0, 1, 0), lift=0.01))
    tie = emitter.tie
    assert tie is not None
    groom, points = emit(emitter, 0), combed(emitter)[:, 1:]
    assert groom.grown is not None
    own = np.arccos(groom.grown[:, 1] / 0.1)
    for at in (0.6, 1.0, 1.4):
        angle = np.arccos(points[..., 1] / np.linalg.norm(points, axis=2))
        height = np.linalg.norm(points, axis=2) - 0.1
        crossing = own > at
        there = np.array([np.interp(-at, -a, h) for a, h in zip(angle[crossing], height[crossing], strict=True)])
        order = np.argsort(own[crossing])
        assert (np.diff(there[order]) > -2e-5).all()
        share = crossing.mean()
        ring = 2 * np.pi * 0.1 * np.sin(at)
        assert there.max() * ring == pytest.approx(np.pi * tie.radius**2 * share, rel=0.02)
        assert there.min() == pytest.approx(0, abs=2e-5)


def test_strands_leave_the_tie_along_its_direction_and_fan_out() -> None:
    leaning = (0.0, 0.5, -1.0)
    groom = emit(emitter_of(tie=dataclasses.replace(TIE, direction=leaning, spread=20.0)), 0)
    axis = np.array(leaning) / np.linalg.norm(leaning)
    off = np.degrees(np.arccos(np.clip(groom.directions @ axis, -1, 1)))
    middle = groom.roots.astype(float).mean(0)
    away = np.linalg.norm(groom.roots - chart_of(emitter_of()).foot - 0.012 * axis, axis=1)
    np.testing.assert_allclose(off, 20.0 * away / TIE.radius, atol=0.02)
    outer = away > 0.5 * TIE.radius
    assert (((groom.roots - middle) * groom.directions).sum(1)[outer] > 0).all()
    assert combed(emitter_of(tie=dataclasses.replace(TIE, direction=leaning)))[:, 1:].shape == (4000, TIED, 3)


SOLIDS = """
solids: [{kind: sphere, name: skull, radius: 0.09, follow: emitter},
  {kind: capsule, name: face, radius: 0.06, length: 0.07, position: [0, -0.05, 0.03], rotation: [25, 0, 0],
   follow: emitter}, {kind: sphere, name: bump, radius: 0.02, position: [0.1, 0.03, 0], follow: emitter}]
"""


def test_strands_are_outside_of_all_that_they_lie_over() -> None:
    def inside(points: np.ndarray) -> np.ndarray:
        """Depth in the deepest of them."""
        turn = np.array(emitter_pose(Emitter(rotation=(25.0, 0.0, 0.0)), 0.0).rotation)
        along = np.clip((points - [0, -0.05, 0.03]) @ turn[:, 1], -0.035, 0.035)[..., None] * turn[:, 1]
        away = np.stack([np.linalg.norm(points, axis=-1) - 0.09,
                         np.linalg.norm(points - [0, -0.05, 0.03] - along, axis=-1) - 0.06,
                         np.linalg.norm(points - [0.1, 0.03, 0], axis=-1) - 0.02])  # fmt: skip
        return np.asarray(-away.min(0))

    scene = scene_of(SCENE.replace("lift: 0.012", "lift: 0.012, over: [skull, face, bump]") + SOLIDS)
    free = combed(dataclasses.replace(scene.emitter, tie=dataclasses.replace(scene.emitter.tie, over=())), scene)
    kept = combed(scene.emitter, scene)
    assert inside(free[:, 1:]).max() > 5e-3
    assert inside(kept[:, 1:]).max() < 5e-6  # where a way out grazes the surface, the last micrometres take many steps
    # on it, not far above: by what keeps it from being drawn into the surface
    roots = inside(free[:, 1]) > 0
    assert inside(kept[roots, 1]).min() > -0.001
    # where nothing is in the way, nothing moves
    clear = (inside(free[:, 1:]) < -2e-3).all(1)
    assert clear.sum() > 10
    np.testing.assert_allclose(kept[clear], free[clear], atol=1e-7)


def test_slack_is_of_few_strands_and_never_more_than_asked() -> None:
    tight, loose = combed(emitter_of()), combed(emitter_of(tie=dataclasses.replace(TIE, slack=0.01)))
    off = np.linalg.norm(loose - tight, axis=2).max(1)
    assert 0.008 < off.max() < 0.01 * np.sqrt(2) * 1.02
    assert np.median(off) < 0.001
    np.testing.assert_array_equal(loose[:, 1], tight[:, 1])


def test_slack_is_up_as_the_sixth_power_of_an_even_number_and_aside_by_any_share_of_that() -> None:
    tight = combed(emitter_of(strands=20_000))
    loose = combed(emitter_of(strands=20_000, tie=dataclasses.replace(TIE, slack=0.01)))
    foot = np.array(TIE.position) / np.linalg.norm(TIE.position)
    roots = tight[:, 1]
    along = roots - (roots @ foot)[:, None] * foot
    aside = np.cross(foot, along / np.linalg.norm(along, axis=1, keepdims=True))
    most = np.linalg.norm(loose - tight, axis=2).argmax(1)
    every = np.arange(len(roots))
    off, normals = (loose - tight)[every, most], tight[every, most]
    # of a bow over the whole way, which is greatest in its middle
    ahead, whole = (np.arccos((one @ foot) / np.linalg.norm(one, axis=1)) for one in (normals, roots))
    off /= np.sin(np.pi * ahead / whole)[:, None] ** 2
    bowed = (off * aside).sum(1)
    up = ((off - bowed[:, None] * aside) * normals).sum(1) / np.linalg.norm(normals, axis=1)
    for share in (0.5, 0.75, 0.9):
        assert np.quantile(up, share) == pytest.approx(0.01 * share**6, rel=0.1)
    large = up > 1e-4
    shares = bowed[large] / up[large]
    for share in (0.1, 0.5, 0.9):
        assert np.quantile(shares, share) == pytest.approx(2 * share - 1, abs=0.06)
    assert abs(np.corrcoef(shares, up[large])[0, 1]) < 0.1


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


CHIN = """
solids:
- {kind: capsule, name: face, radius: 0.05, length: 0.1, position: [0, 0.02, 0.07], follow: emitter}
- {kind: sphere, name: skull, radius: 0.11, follow: emitter}
"""


def test_strands_lie_on_what_is_wider_than_the_emitter() -> None:
    def on(solids: str, over: str, **emitter: Any) -> np.ndarray:
        scene = scene_of(SCENE.replace("lift: 0.012", f"lift: 0.012, over: {over}") + solids)
        one = dataclasses.replace(scene.emitter, **emitter)
        return combed(one, scene)[:, 1:]

    one = on("solids: [{kind: sphere, name: a, radius: 0.13, follow: emitter}]\n", "[a]")
    away = np.linalg.norm(one, axis=2)  # no hair is below that at its own root
    np.testing.assert_allclose(away[:, 0], 0.13, atol=2e-7)
    both = on(CHIN, "[face, skull]")
    middle = both - np.array([0, 0.02, 0.07])
    middle[..., 1] -= np.clip(middle[..., 1], -0.05, 0.05)
    apart = np.stack([np.linalg.norm(both, axis=2) - 0.11, np.linalg.norm(middle, axis=2) - 0.05])
    # at the root, whose way out is the ball's own normal, and which nothing else lifts
    assert np.abs(apart.min(0)[:, 0]).max() < 2e-6
    assert np.bincount(apart.argmin(0)[:, 0], minlength=2).min() > 10  # on either
    # as the emitter stands at first nothing is otherwise
    keys = tuple(dataclasses.replace(key, position=(0.5, -0.2, 0.1)) for key in scene_of(SCENE).emitter.keys)
    np.testing.assert_allclose(on(CHIN, "[face, skull]", keys=keys), both, atol=1e-7)


def test_the_way_out_is_the_first_one() -> None:
    """Of balls and capsules, for points and directions at random."""
    rng = np.random.default_rng(3)
    rows = np.zeros((6, capsule.COLUMNS))
    rows[:, :3] = rng.uniform(-0.1, 0.1, (6, 3))
    rows[:4, AXIS] = rng.uniform(-0.1, 0.1, (4, 3))
    rows[:4, capsule.PER_SQUARE] = 1 / (rows[:4, AXIS] ** 2).sum(1)
    rows[:, capsule.RADIUS] = rng.uniform(0.03, 0.06, 6)

    def apart(points: np.ndarray) -> np.ndarray:
        from_ends = points[..., None, :] - rows[:, :3]
        along = np.clip((from_ends * rows[:, AXIS]).sum(-1) * rows[:, capsule.PER_SQUARE], 0, 1)
        each = np.linalg.norm(from_ends - along[..., None] * rows[:, AXIS], axis=-1) - rows[:, capsule.RADIUS]
        return np.asarray(each.min(-1))

    points, normals = rng.uniform(-0.15, 0.15, (400, 3)), rng.normal(size=(400, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    up = np.zeros(400)
    lift(points, normals, rows, up)
    outside = apart(points) >= 0
    assert 50 < outside.sum() < 350
    np.testing.assert_array_equal(up[outside], 0)
    assert up[~outside].min() > 0
    np.testing.assert_allclose(apart(points + up[:, None] * normals)[~outside], 0, atol=1.1e-7)
    before = np.linspace(0, 0.999, 200)[:, None] * up[~outside]
    assert apart(points[~outside] + before[..., None] * normals[~outside]).max() < 0


def test_a_strand_does_not_depend_on_how_many_there_are_nor_on_threads() -> None:
    tie = dataclasses.replace(TIE, slack=0.01)
    many = combed(emitter_of(tie=tie))
    np.testing.assert_array_equal(combed(emitter_of(tie=tie, strands=100)), many[:100])
    scene = scene_of(SCENE.replace("lift: 0.012", "lift: 0.012, over: [skull, face, bump]") + SOLIDS)
    before = numba.get_num_threads()
    all_threads = combed(scene.emitter, scene)
    try:
        numba.set_num_threads(1)
        np.testing.assert_array_equal(combed(scene.emitter, scene), all_threads)
    finally:
        numba.set_num_threads(before)
