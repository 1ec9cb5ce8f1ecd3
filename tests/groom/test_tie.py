"""Tied strands: shortest paths over the emitter, hair that keeps its volume and hair that is too short for the tie, in
any order, in runs and on meshes: drawn, studied, with children, planned, refused."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
from numpy.typing import NDArray

from mesh_kit import ply, sphere
from scene_kit import complaint
from strand_kit import frames_of, scene_of
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.geometry.curves import flatten
from strandcli.draw.view.camera import camera_view
from strandcli.groom.blocks import arranged, lanes, pack, unpack
from strandcli.groom.combed import Combed
from strandcli.groom.emit import emit
from strandcli.groom.record import Groom
from strandcli.groom.tie import OFF, chart_of, chosen, wisps
from strandcli.meshes.make import make_mesh
from strandcli.plan import make_plan
from strandcli.scene.model import Camera, Curves, Emitter, MeshShape, Scene, SphereShape, Tie
from strandcli.scene.model.emitter import TIED
from strandcli.scene.motion import emitter_pose

LENGTH, ROWS, RADIUS = 0.02, 30, 0.1
"""Of wisps, metres; their rows; that of the ball that strands grow on, metres."""
SPHERE = SphereShape(radius=RADIUS, cap=110)
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


def on_emitter(scene: Scene, points: np.ndarray, at: float) -> np.ndarray:
    """Points in the frame that the emitter has at a time."""
    rotation, shift = (np.array(part) for part in emitter_pose(scene.emitter, at))
    return np.asarray((points - shift) @ rotation)


def test_strands_are_joined_at_the_tie_and_move_rigidly_with_the_emitter() -> None:
    scene = scene_of(SCENE)
    groom = emit(scene.emitter, scene.seed)
    whole = Combed(scene, groom)
    hanging = np.random.default_rng(1).normal(size=(300, 7, 3)).astype(np.float32)
    for at in (0.0, 0.4, 1.0):
        joined = unpack(whole.join(pack(hanging), at, 300, Scratch()), 300)
        np.testing.assert_allclose(on_emitter(scene, joined[:, : 1 + TIED], at), whole.points, atol=2e-7)
        np.testing.assert_array_equal(joined[:, 1 + TIED :], hanging[:, 1:])
    still = dataclasses.replace(scene, rules=scene.rules[1:])  # nothing carries the emitter along
    stays = unpack(Combed(still, groom).join(pack(hanging), 1.0, 300, Scratch()), 300)
    first = unpack(whole.join(pack(hanging), 0.0, 300, Scratch()), 300)
    np.testing.assert_array_equal(stays, first)
    some = np.array([250, 3, 17], np.int32)
    part = unpack(whole.join(pack(hanging[some]), 1.0, 3, Scratch(), some), 3)
    np.testing.assert_array_equal(part, joined[some])


def test_curves_through_uneven_points_of_a_circle_stay_on_it() -> None:
    """Segments of which each is a third longer than the one before: by their chords the curve is on the circle, and
    with one length for all it is not."""
    angles = np.cumsum([0.0, *(0.02 * 1.35 ** np.arange(9))])
    ring = np.stack([np.cos(angles), np.sin(angles), 0 * angles], 1)
    before = ring[0] - 0.1 * np.array([0.0, 1.0, 0.0])
    positions = pack(np.concatenate([before[None], ring])[None])
    view = camera_view(Camera(position=(0.0, 0.0, 3.0)), 0.0, 400, 400, np.array([[-1.0] * 3, [1.0] * 3]))
    curves = Curves(mode="fixed", level=4)

    def off(lengths: np.ndarray | None) -> float:
        world = flatten(positions, lengths, 1, curves, view, True, Scratch()).world[: -(2**4)].astype(float)
        return float(np.abs(np.linalg.norm(world, axis=1) - 1).max())

    assert off(None) < 3e-4
    assert off(lanes(np.array([[0.1]]))) > 1e-3
    # and where points are even, both are the same curve
    even = np.stack([np.cos(0.1 * np.arange(9)), np.sin(0.1 * np.arange(9)), np.zeros(9)], 1)
    positions = pack(np.concatenate([[even[0] - even[1] + even[0]], even])[None])
    chord = float(np.linalg.norm(even[1] - even[0]))
    for mode in ("fixed", "adaptive"):
        first, second = (
            flatten(positions, lengths, 1, Curves(mode=mode, level=4), view, True, Scratch()).world.copy()
            for lengths in (None, lanes(np.array([[chord]])))
        )
        np.testing.assert_allclose(first, second, atol=1e-6)
    lines = flatten(positions, None, 1, curves, view, True, Scratch())
    assert lines.segment == pytest.approx(chord, rel=1e-5)


def test_a_frame_of_tied_strands_covers_the_scalp_and_solvers_know_only_what_hangs() -> None:
    text = SCENE + "image: {size: [80, 60], resolver: sorted, aovs: [mask]}\nmaterial: {width: 0.002}\n"
    camera = Camera(position=(0.1, 0.2, 0.8), target=(0.1, 0.2, 0.3), fov=40)
    tied = dataclasses.replace(scene_of(text), camera=camera)
    (frame,) = frames_of(tied, 25)
    bound = emit(tied.emitter, tied.seed)
    assert frame.positions.shape == (300, 6, 3)
    np.testing.assert_allclose(on_emitter(tied, frame.positions[:, 0], 1.0), bound.roots, atol=1e-6)
    assert frame.report["counts"]["particles"] == 300 * (TIED + 6)
    assert "combed" in frame.report["seconds"]
    assert frame.report["error"]["stretch_max"] < 1e-3
    # the front of the head, which nothing hangs over, is covered
    ball = frame.aovs["mask"][20:40, 30:50]
    assert (ball > 0.3).mean() > 0.5
    children = dataclasses.replace(tied, children=dataclasses.replace(scene_of("children: {}").children, count=4))
    (more,) = frames_of(children, 25)
    assert more.report["counts"]["strands"] == 1200
    assert more.aovs["mask"][20:40, 30:50].mean() > ball.mean()


def test_a_plan_tells_of_what_is_combed() -> None:
    stages = {one.stage: one.why for one in make_plan(scene_of(SCENE), [1]).used}
    assert str(TIED) in stages["combed parts"]
    left = {one.stage for one in make_plan(scene_of("emitter: {strands: 10}"), [1]).left_out}
    assert "combed parts" in left


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("tie: {position: [0, -1, 0]}, shape: {kind: sphere, cap: 90}",
         "the tie is above no place of the emitter's surface that strands grow from; move it there"),
        ("tie: {position: [0.6, 0, 0]}, shape: {kind: disc, radius: 0.5}", "strands are tied on a sphere or a mesh"),
        ("tie: {direction: [1, -0.1, 0]}",
         "p.yaml:1:28: emitter.tie.direction: points into the emitter's surface; turn it outward"),
        ("tie: {}, comb: [1, 0, 0]", "strands that are tied are combed to their tie; take one of the two out"),
        ("tie: {radius: 0}", "emitter.tie.radius: must be a number above 0"),
        ("tie: {wisps: 1.5}", "emitter.tie.wisps: must be a number"),
        ("tie: {wisp_length: 0}", "emitter.tie.wisp_length: must be a number"),
    ],
)  # fmt: skip
def test_refused(text: str, says: str) -> None:
    assert says in complaint(f"emitter: {{{text}}}")


STRETCH = np.array([0.8, 1.0, 1.1])


def on_ellipsoid(folder: Path, stretch: np.ndarray) -> Emitter:
    """An ellipsoid on which strands grow above a plane."""
    vertices, triangles = sphere(5)
    mesh = make_mesh(RADIUS * stretch * vertices, triangles)
    file = folder / "ball.ply"
    file.write_bytes(ply(mesh, more={"scalp": (mesh.vertices[:, 1] > -0.3 * RADIUS * stretch[1]) * 1.0}))
    return Emitter(strands=2000, length=0.3, shape=MeshShape(file=str(file), density="scalp"), tie=TIE)


def test_a_mesh_of_a_sphere_is_as_the_sphere(tmp_path: Path) -> None:
    """The foot, the rim, the ends in the bundle and the height of the strands over the surface."""
    one = on_ellipsoid(tmp_path, np.ones(3))
    mesh = chart_of(one)
    shape = SphereShape(radius=RADIUS, cap=float(np.degrees(np.arccos(-0.3))))
    ball = chart_of(Emitter(shape=shape, tie=TIE))
    np.testing.assert_allclose(mesh.foot, ball.foot, atol=0.01 * RADIUS)
    turn = np.linspace(0, 2 * np.pi, 50)
    some = np.cross(mesh.normal, [1.0, 0, 0])
    some /= np.linalg.norm(some)
    ways = np.cos(turn)[:, None] * some + np.sin(turn)[:, None] * np.cross(mesh.normal, some)
    np.testing.assert_allclose(mesh.rim(ways) / mesh.radius, ball.rim(ways) / ball.radius, atol=0.09)
    points = combed(one)[:, 1:]
    roots = points[:, 0] / np.linalg.norm(points[:, 0], axis=1)[:, None]
    plane = np.cross(mesh.normal, roots)
    plane /= np.linalg.norm(plane, axis=1)[:, None]
    off = np.abs(np.einsum("nkc,nc->nk", points[:, :13], plane)).max()
    assert off < 1e-6, "ways are great circles"


@pytest.mark.parametrize("stretch", [np.ones(3), STRETCH])
def test_strands_lie_on_the_mesh(tmp_path: Path, stretch: np.ndarray) -> None:
    one = on_ellipsoid(tmp_path, stretch)
    far = np.linalg.norm(combed(one)[:, 1:] / stretch, axis=2) / RADIUS
    assert far.min() > 0.998, "none is in it"
    assert far[:, 0].max() < 1.02, "roots are on it"
    assert np.linalg.norm(combed(one)[:, -1] - chart_of(one).foot, axis=1).max() < 3 * TIE.lift, "and end at the tie"


WISPS = dataclasses.replace(TIE, wisps=0.6, wisp_length=LENGTH)


def test_they_are_as_many_as_asked_at_the_rim_and_fewer_by_the_exponential_law() -> None:
    emitter = emitter_of(strands=400_000, tie=WISPS)
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
    emitter = emitter_of(tie=WISPS)
    groom = emit(emitter, 0)
    rng = np.random.default_rng(1)
    roots = groom.grown[chosen(emitter, groom, rng.random(4000))]
    assert len(roots) > 100
    lots = rng.random((len(roots), 4))
    points = wisps(emitter, roots, lots, ROWS, lambda points, _: np.zeros(len(points))).astype(float)
    above = np.linalg.norm(points[:, 1:], axis=-1) - RADIUS
    assert above.min() > -1e-7
    assert above.max() <= OFF * LENGTH


def joined(scene: Scene, groom: Groom, at: float, ids: NDArray[np.int32] | None = None) -> NDArray[np.float64]:
    """(strands, rows, 3) at a time, with something that hangs from the tie; of those called ``ids`` or all."""
    hanging = np.random.default_rng(0).normal(size=(300, 7, 3)).astype(np.float32)
    some = hanging if ids is None else hanging[ids]
    return unpack(Combed(scene, groom).join(pack(some), at, len(some), Scratch(), ids), len(some)).astype(float)


def test_they_are_drawn_in_place_of_what_is_tied_and_move_with_the_emitter() -> None:
    scene, none = (scene_of(SCENE.replace("lift: 0.012", f"lift: 0.012, wisps: {share}")) for share in (0.7, 0))
    groom = emit(scene.emitter, scene.seed)
    short = Combed(scene, groom).short
    assert 20 < len(short) < 150
    assert len(Combed(none, groom).short) == 0
    rest = np.setdiff1d(np.arange(300), short)
    now, tied = joined(scene, groom, 1.0), joined(none, groom, 1.0)
    np.testing.assert_array_equal(now[rest], tied[rest])
    first, last = (on_emitter(scene, joined(scene, groom, at), at)[short] for at in (0.0, 1.0))
    np.testing.assert_allclose(last[:, 1], groom.grown[short], atol=1e-7)
    np.testing.assert_allclose(last, first, atol=1e-7)
    assert now.shape[1] == 1 + TIED + 6
    assert np.linalg.norm(np.diff(first[:, 1:], axis=1), axis=2).sum(1).max() < 1.3 * scene.emitter.tie.wisp_length
