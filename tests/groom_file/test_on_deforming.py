"""Hair of a file on a head that deforms: roots follow their triangles, and strands turn with them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mesh_kit
from groom_file_kit import scene, write
from strandcli.groom.blocks import unpack
from strandcli.groom_file import from_scene
from strandcli.meshes.mesh import TriangleMesh
from strandcli.run.stages import RunOptions, SimulationStage
from strandcli.scene.model import Scene
from tests.groom_file.test_followers import follow, stage_of

MATRIX, SHIFT = np.array([[1.2, 0.3, 0.0], [0.0, 0.8, 0.1], [0.2, 0.0, 1.1]]), np.array([0.05, 0.1, -0.2])
QUARTER = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
VERTICES, TRIANGLES = mesh_kit.sphere(3)
VERTICES = 0.1 * VERTICES / np.linalg.norm(VERTICES, axis=1).mean()


def strands(count: int = 60, points: int = 12) -> np.ndarray:
    """(count, points, 3) strands that leave the middles of some triangles, and bow, metres."""
    rows = np.random.default_rng(5).permutation(len(TRIANGLES))[:count]
    roots = VERTICES[TRIANGLES[rows]].mean(axis=1)
    way = roots / np.linalg.norm(roots, axis=1)[:, None]
    t = np.linspace(0, 0.1, points)[:, None, None]
    rows = roots + t * way + 3 * t**2 * np.array([0.3, 0.5, 0.2])
    return np.ascontiguousarray(rows.transpose(1, 0, 2)).astype(np.float32)


def on_head(folder: Path, matrix: np.ndarray, shift: np.ndarray, rules: list[Any], **more: Any) -> Scene:
    """Strands on a ball that is another one, under an affine map, one second later."""
    for name, vertices in (("a", VERTICES), ("b", VERTICES @ matrix.T + shift)):
        (folder / f"{name}.obj").write_bytes(mesh_kit.obj(TriangleMesh(vertices, TRIANGLES, vertices)))
    head = {
        "kind": "mesh", "name": "head", "file": str(folder / "a.obj"), "follow": "emitter",
        "deform": [{"time": t, "file": str(folder / f"{name}.obj")} for t, name in ((0.0, "a"), (1.0, "b"))],
    }  # fmt: skip
    given = {
        "emitter.groom.on": "head", "solids": [head], "rules": rules, "time.fps": 10, "time.frames": 11,
        "emitter.groom.colours": "none", "emitter.groom.root": "first", "detail": None,
    }  # fmt: skip
    path = write(folder / "hair.data", list(strands()))
    return scene(path, **given | {key.replace("__", "."): value for key, value in more.items()})


def still(given: Scene, frame: int) -> np.ndarray:
    """Strands that are not simulated, in the order of the file, at a frame."""
    stage = SimulationStage(given, [frame], None, RunOptions())
    moved = stage.begin(frame)
    return unpack(moved.positions[:, 1:], stage.groom.strands)[np.argsort(moved.ids)]


@pytest.mark.parametrize("keys", [[], [{"time": 0.0, "position": [0.3, 0, 0], "rotation": [0, 40, 0]}]])
def test_strands_that_are_not_simulated_turn_with_their_triangles(tmp_path: Path, keys: list[Any]) -> None:
    """A turn and a shift of the mesh are those of each strand, also in the frame of an emitter that stands elsewhere,
    with its head; and at the start strands are those of the file."""
    given = on_head(tmp_path, QUARTER, SHIFT, ["emitter_motion"], emitter__keys=keys)
    pose = np.eye(3), np.zeros(3)
    if keys:
        angle = np.radians(40)
        turn = [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
        pose = np.array(turn), np.array([0.3, 0, 0])
    start = unpack(from_scene(given).groom.points[:, 1:], 60)[np.argsort(from_scene(given).groom.places)]  # type: ignore[index,arg-type]
    np.testing.assert_allclose(still(given, 1), start @ pose[0].T + pose[1], atol=1e-6)
    np.testing.assert_allclose(still(given, 11), (start @ QUARTER.T + SHIFT) @ pose[0].T + pose[1], atol=1e-6)


def test_without_emitter_motion_nothing_follows(tmp_path: Path) -> None:
    given = on_head(tmp_path, QUARTER, SHIFT, [])
    np.testing.assert_array_equal(still(given, 11), still(given, 1))


@pytest.mark.parametrize("solver", ["rod", "thesis"])
def test_roots_of_simulated_strands_are_on_the_mesh_at_every_frame(tmp_path: Path, solver: str) -> None:
    """Guides, and all that follow them, stand where the affine map has their roots."""
    rules: list[Any] = ["emitter_motion"] + (["elasticity"] if solver == "thesis" else [])
    given = on_head(tmp_path, MATRIX, SHIFT, rules, solver=solver, emitter__groom__guides=12, emitter__particles=8)
    stage, children = stage_of(given)
    start = None
    for frame, share in ((1, 0.0), (4, 0.3), (11, 1.0)):
        moved = stage.begin(frame)
        found = follow(children, moved.positions, (frame - 1) / given.time.fps)
        start = found[:, 0].astype(np.float64) if start is None else start
        wanted = start + share * (start @ (MATRIX - np.eye(3)).T + SHIFT)
        np.testing.assert_allclose(found[:, 0], wanted, atol=2e-6)
