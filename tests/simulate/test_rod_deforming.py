"""Rods on a mesh that deforms: friction carries them as it does on a solid that moves."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import mesh_kit as kit
from strandcli.meshes.mesh import TriangleMesh
from tests.simulate.test_rod_contact import against
from tests.simulate.test_rod_motion import first

SECONDS, RATE, SHIFT = 2.0, 24, 0.2
TOP = -0.2


def slab(folder: Path, shift: float = 0.0, turn: float = 0.0) -> str:
    """A file of a slab whose top is at the height `TOP`, shifted along z, and turned about y by so many radians."""
    box = kit.mesh("box")
    vertices = box.vertices * (1.5, 0.3, 1.5)
    vertices[:, 1] += TOP - vertices[:, 1].max()
    x, y, z = vertices.T
    vertices = np.stack([np.cos(turn) * x + np.sin(turn) * z, y, np.cos(turn) * z - np.sin(turn) * x + shift], axis=1)
    path = folder / f"slab_{shift}_{turn}.obj"
    path.write_bytes(kit.obj(TriangleMesh(vertices, box.triangles, vertices)))
    return str(path)


def moved(friction: float, **solid: Any) -> np.ndarray:
    """Particles of a strand that lies on a mesh, after some seconds."""
    one = {"emitter.strands": 3, "emitter.jitter": 0.0, "rod.friction": friction, "rod.damping": 0.01}
    solver = against([{"kind": "mesh", **solid}], 100.0, double=True, **one)
    for i in range(int(SECONDS * RATE)):
        solver.step((i + 1) / RATE, 1 / RATE)
    assert solver.errors(1)["penetration_max"] < 1e-3  # type: ignore[operator]
    return first(solver)


def test_a_surface_that_slides_carries_strands_as_a_solid_that_moves(tmp_path: Path) -> None:
    """The same motion by files and by keys, of a slab that a strand rests on; straight lines in time are both."""
    here, there = slab(tmp_path), slab(tmp_path, SHIFT)
    keys = [{"time": 0, "ease": "linear"}, {"time": SECONDS, "position": [0, 0, SHIFT]}]
    rigid = moved(1.0, file=here, keys=keys)
    sliding = moved(1.0, file=here, deform=[{"time": 0, "file": here}, {"time": SECONDS, "file": there}])
    still = moved(1.0, file=here)
    assert rigid[-1, 2] - still[-1, 2] > 0.05
    np.testing.assert_allclose(sliding, rigid, atol=1e-5)


def test_without_friction_a_surface_that_slides_carries_nothing(tmp_path: Path) -> None:
    here, there = slab(tmp_path), slab(tmp_path, SHIFT)
    deform = [{"time": 0, "file": here}, {"time": SECONDS, "file": there}]
    np.testing.assert_allclose(moved(0.0, file=here, deform=deform), moved(0.0, file=here), atol=1e-5)


def test_a_surface_that_slides_in_a_solid_that_turns_adds_up(tmp_path: Path) -> None:
    """A slab turned by its keys, whose file slides it along its own axes, is where one is that moves by keys alone; and
    it carries the strand as that does."""
    here, there = slab(tmp_path), slab(tmp_path, SHIFT)
    posed = {"rotation": [0, 90, 0]}
    keys = [{"time": 0, "ease": "linear", **posed}, {"time": SECONDS, "position": [SHIFT, 0, 0], **posed}]
    rigid = moved(1.0, file=here, keys=keys)
    deform = [{"time": 0, "file": here}, {"time": SECONDS, "file": there}]
    sliding = moved(1.0, file=here, deform=deform, **posed)
    np.testing.assert_allclose(sliding, rigid, atol=1e-5)
    half = [{"time": 0, "ease": "linear", **posed}, {"time": SECONDS, "position": [-SHIFT, 0, 0], **posed}]
    held = moved(1.0, file=here, deform=deform, keys=half)
    np.testing.assert_allclose(held, moved(1.0, file=here, **posed), atol=1e-5)
