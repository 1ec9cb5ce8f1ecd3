"""Roots on meshes that deform follow their triangles, in both solvers and for children."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import strandcli
from cli_runs import Runner
from mesh_kit import sphere, write
from scene_kit import RULES
from strandcli.errors import UsageError
from strandcli.groom.blocks import arranged, unpack
from strandcli.groom.children import Children
from strandcli.groom.deforming import at_start
from strandcli.groom.emit import emit
from strandcli.scene.loading import loads
from strandcli.scene.model import Scene
from strandcli.simulate import solver_of

MATRIX, SHIFT = np.array([[1.2, 0.3, 0.0], [0.0, 0.8, 0.1], [0.2, 0.0, 1.1]]), np.array([0.05, 0.1, -0.2])
TURN = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])


def scene_of(folder: Path, matrix: np.ndarray, more: str = "", solver: str = "thesis") -> Scene:
    """Strands on a ball that is another one, under an affine map, one second later."""
    vertices, triangles = sphere()
    first = write(folder / "a.obj", vertices, triangles)
    last = write(folder / "b.obj", vertices @ matrix.T + SHIFT, triangles)
    deform = f"[{{time: 0, file: {first}}}, {{time: 1, file: {last}}}]"
    shape = f"{{kind: mesh, file: {first}, deform: {deform}}}"
    path = folder / "p.yaml"
    path.write_text(
        "time: {fps: 10, frames: 11, substeps: 4}\nrules: [emitter_motion, elasticity]\n"
        f"emitter: {{shape: {shape}, strands: 150, particles: 5, length: 0.2}}\nsolver: {solver}\n{more}"
    )
    return strandcli.load(str(path))


@pytest.mark.parametrize("solver", ["thesis", "rod"])
def test_roots_follow_affine_deformation_in_both_solvers(tmp_path: Path, solver: str) -> None:
    scene = scene_of(tmp_path, MATRIX, solver=solver)
    groom = at_start(scene, arranged(emit(scene.emitter, scene.seed)))
    moved = solver_of(scene)(scene, groom)
    start = moved.particles()[:, 0].astype(np.float64)
    for frame, share in ((1, 0.0), (4, 0.3), (11, 1.0)):
        moved.advance(frame)
        wanted = start + share * (start @ (MATRIX - np.eye(3)).T + SHIFT)
        np.testing.assert_allclose(moved.particles()[:, 0], wanted, atol=2e-6)
    assert moved.errors(11)["stretch_max"] < 2e-3  # type: ignore[operator]


@pytest.mark.parametrize("solver", ["thesis", "rod"])
def test_directions_turn_with_the_triangles(tmp_path: Path, solver: str) -> None:
    """After a quarter turn the clamped edge before the root has turned too."""
    scene = scene_of(tmp_path, TURN, solver=solver)
    groom = at_start(scene, arranged(emit(scene.emitter, scene.seed)))
    moved = solver_of(scene)(scene, groom)
    moved.advance(11)
    rows = unpack(moved.positions, moved.strands).astype(np.float64)
    way = (rows[:, 1] - rows[:, 0]) / np.linalg.norm(rows[:, 1] - rows[:, 0], axis=1)[:, None]
    np.testing.assert_allclose(way, groom.directions @ TURN.T, atol=1e-4)


def test_roots_of_children_follow(tmp_path: Path) -> None:
    scene = scene_of(tmp_path, MATRIX, "children: {count: 3}\n")
    guides = arranged(emit(scene.emitter, scene.seed))
    children = Children(scene, guides)
    start, end = children._deforming.roots(0.0), children._deforming.roots(1.0)
    np.testing.assert_allclose(start, children.every.roots, atol=1e-6)
    np.testing.assert_allclose(end, start @ MATRIX.T + SHIFT, atol=1e-7)


def test_other_topology_and_keys_out_of_order_are_refused(tmp_path: Path, run: Runner) -> None:
    scene = scene_of(tmp_path, MATRIX)
    write(tmp_path / "b.obj", *sphere(1))
    with pytest.raises(UsageError, match=r"b\.obj: has 18 vertices, the mesh that it moves has 258"):
        at_start(scene, emit(scene.emitter, scene.seed))
    assert "emitter.shape.deform.1.file" in run.refused("plan", tmp_path / "p.yaml")
    shape = f"kind: mesh, file: {tmp_path / 'a.obj'}, deform: "
    for deform, words in (
        (f"[{{time: 1, file: {tmp_path / 'a.obj'}}}, {{time: 0, file: {tmp_path / 'a.obj'}}}]", "forward in time"),
        ("[{time: 0}]", "must be the path of a mesh"),
    ):
        with pytest.raises(UsageError, match=words):
            loads(f"emitter: {{shape: {{{shape}{deform}}}}}", rules=RULES, name="p.yaml")
