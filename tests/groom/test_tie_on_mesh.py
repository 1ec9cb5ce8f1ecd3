"""Ties of strands that grow on a mesh."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mesh_kit import ply, sphere
from strandcli.groom.combed import Combed
from strandcli.groom.emit import emit
from strandcli.groom.tie import chart_of
from strandcli.meshes.make import make_mesh
from strandcli.scene.model import Emitter, MeshShape, Scene, SphereShape, Tie

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
