"""Strands that are tied, in runs and on meshes: drawn, studied, with children, planned, refused."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from mesh_kit import ply, sphere
from scene_kit import complaint
from strand_kit import frames_of, scene_of
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.geometry.curves import flatten
from strandcli.draw.view.camera import camera_view
from strandcli.groom.blocks import lanes, pack, unpack
from strandcli.groom.combed import Combed
from strandcli.groom.emit import emit
from strandcli.groom.tie import chart_of
from strandcli.meshes.make import make_mesh
from strandcli.plan import make_plan
from strandcli.scene.model import Camera, Curves, Emitter, MeshShape, Scene, SphereShape, Tie
from strandcli.scene.model.emitter import TIED
from strandcli.scene.motion import emitter_pose
from tests.groom.test_tie import SCENE


def test_strands_are_joined_at_the_tie_and_move_rigidly_with_the_emitter() -> None:
    scene = scene_of(SCENE)
    groom = emit(scene.emitter, scene.seed)
    whole = Combed(scene, groom)
    hanging = np.random.default_rng(1).normal(size=(300, 7, 3)).astype(np.float32)
    for at in (0.0, 0.4, 1.0):
        joined = unpack(whole.join(pack(hanging), at, 300, Scratch()), 300)
        rotation, shift = (np.array(part) for part in emitter_pose(scene.emitter, at))
        np.testing.assert_allclose((joined[:, : 1 + TIED] - shift) @ rotation, whole.points, atol=2e-7)
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
    rotation, shift = (np.array(part) for part in emitter_pose(tied.emitter, 1.0))
    assert frame.positions is not None
    assert frame.positions.shape == (300, 6, 3)
    np.testing.assert_allclose(frame.positions[:, 0], bound.roots @ rotation.T + shift, atol=1e-6)
    assert frame.report["counts"]["particles"] == 300 * (TIED + 6)
    assert "combed" in frame.report["seconds"]
    assert frame.report["error"]["stretch_max"] < 1e-3
    assert frame.aovs is not None
    # the front of the head, which nothing hangs over, is covered
    ball = frame.aovs["mask"][20:40, 30:50]
    assert (ball > 0.3).mean() > 0.5
    children = dataclasses.replace(tied, children=dataclasses.replace(scene_of("children: {}").children, count=4))
    (more,) = frames_of(children, 25)
    assert more.report["counts"]["strands"] == 1200
    assert more.aovs is not None
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
    ],
)  # fmt: skip
def test_refused(text: str, says: str) -> None:
    assert says in complaint(f"emitter: {{{text}}}")


RADIUS = 0.1
TIE = Tie(position=(0.01, 0.09, -0.04), radius=0.016, lift=0.012)
STRETCH = np.array([0.8, 1.0, 1.1])


def emitter(folder: Path, stretch: np.ndarray) -> Emitter:
    """An ellipsoid on which strands grow above a plane."""
    vertices, triangles = sphere(5)
    mesh = make_mesh(RADIUS * stretch * vertices, triangles)
    file = folder / "ball.ply"
    file.write_bytes(ply(mesh, more={"scalp": (mesh.vertices[:, 1] > -0.3 * RADIUS * stretch[1]) * 1.0}))
    return Emitter(strands=2000, length=0.3, shape=MeshShape(file=str(file), density="scalp"), tie=TIE)


def combed(one: Emitter) -> np.ndarray:
    """(strands, points, 3) from the root to the tie, in the emitter's frame."""
    return Combed(Scene(emitter=one), emit(one, 0)).points[:, 1:].astype(np.float64)


def test_a_mesh_of_a_sphere_is_as_the_sphere(tmp_path: Path) -> None:
    """The foot, the rim, the ends in the bundle and the height of the strands over the surface."""
    one = emitter(tmp_path, np.ones(3))
    mesh = chart_of(one)
    shape = SphereShape(radius=RADIUS, cap=float(np.degrees(np.arccos(-0.3))))
    ball = chart_of(Emitter(shape=shape, tie=TIE))
    np.testing.assert_allclose(mesh.foot, ball.foot, atol=0.01 * RADIUS)
    turn = np.linspace(0, 2 * np.pi, 50)
    some = np.cross(mesh.normal, [1.0, 0, 0])
    some /= np.linalg.norm(some)
    ways = np.cos(turn)[:, None] * some + np.sin(turn)[:, None] * np.cross(mesh.normal, some)
    np.testing.assert_allclose(mesh.rim(ways) / mesh.radius, ball.rim(ways) / ball.radius, atol=0.09)
    points = combed(one)
    roots = points[:, 0] / np.linalg.norm(points[:, 0], axis=1)[:, None]
    plane = np.cross(mesh.normal, roots)
    plane /= np.linalg.norm(plane, axis=1)[:, None]
    off = np.abs(np.einsum("nkc,nc->nk", points[:, :13], plane)).max()
    assert off < 1e-6, "ways are great circles"


@pytest.mark.parametrize("stretch", [np.ones(3), STRETCH])
def test_strands_lie_on_the_mesh(tmp_path: Path, stretch: np.ndarray) -> None:
    one = emitter(tmp_path, stretch)
    far = np.linalg.norm(combed(one) / stretch, axis=2) / RADIUS
    assert far.min() > 0.998, "none is in it"
    assert far[:, 0].max() < 1.02, "roots are on it"
    assert np.linalg.norm(combed(one)[:, -1] - chart_of(one).foot, axis=1).max() < 3 * TIE.lift, "and end at the tie"
