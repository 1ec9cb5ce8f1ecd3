"""Strands of a file that moves: its roots drive simulated ones."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import exchange_kit as kit
import groom_file_kit as groom_kit
from strandcli.errors import UsageError
from strandcli.exchange.files import write
from strandcli.exchange.strands import TimeSample
from strandcli.run.stages import RunOptions, SimulationStage
from strandcli.scene.model import Scene
from tests.groom_file.test_followers import follow, stage_of

STRANDS = groom_kit.hanging([9] * 12)
SHIFT = np.array([0.05, 0.1, -0.2])
QUARTER = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])


def affine(matrix: Any, share: float) -> np.ndarray:
    """Points of all strands, a share of the way from where they are to where a matrix and `SHIFT` have them."""
    points = kit.of(STRANDS).points.astype(np.float64)
    return points + share * (points @ np.asarray(matrix).T + SHIFT - points)


def moving(folder: Path, matrix: Any, rules: list[Any], last: int = 11, **more: Any) -> Scene:
    """A file whose strands are moved within a second."""
    samples = [TimeSample(i / 10, affine(matrix, i / 10).astype(np.float32)) for i in range(last)]
    write(folder / "moving.abc", kit.of(STRANDS), samples)
    given = {"rules": rules, "emitter.groom.guides": 12, "emitter.particles": 8, "detail": None}
    return groom_kit.scene(folder / "moving.abc", **given, **{key.replace("__", "."): one for key, one in more.items()})


@pytest.mark.parametrize("solver", ["rod", "thesis"])
def test_roots_are_where_the_file_has_them_at_every_frame(tmp_path: Path, solver: str) -> None:
    rules: list[Any] = ["emitter_motion"] + (["elasticity"] if solver == "thesis" else [])
    matrix = [[1.2, 0.3, 0.0], [0.0, 0.8, 0.1], [0.2, 0.0, 1.1]]
    given = moving(tmp_path, matrix, rules, solver=solver, time__substeps=3)
    stage, children = stage_of(given)
    for frame in (1, 4, 11):
        found = follow(children, stage.begin(frame).positions, (frame - 1) / given.time.fps)
        np.testing.assert_allclose(found[:, 0], affine(matrix, (frame - 1) / 10)[::9], atol=2e-6)


def test_rods_turn_with_their_roots(tmp_path: Path) -> None:
    """After a turn and time to settle, curled rods without weight are the turned ones, with their twist; but one that
    is folded at a joint, by 151 degrees: iterations do not end there."""
    steel = {"rod.density": 7850.0, "rod.radius": 2.5e-4, "rod.young": 2.0e11}
    rod = {"solver": "rod", "rod.rest": "shape", **steel, "rod.damping": 0.05, "time.frames": 60}
    stage, _ = stage_of(moving(tmp_path, QUARTER, ["emitter_motion"], emitter__groom__scale=0.05, **rod))
    before = stage.solver.particles()
    stage.begin(60)
    edges = np.diff(before, axis=1)
    turns = (edges[:, 1:] * edges[:, :-1]).sum(2) / np.linalg.norm(edges[:, 1:], axis=2) ** 2
    folded = turns.min(1) < -0.5
    assert folded.sum() == 1
    wanted = before @ QUARTER.T + 0.05 * SHIFT
    np.testing.assert_allclose(stage.solver.particles()[~folded], wanted[~folded], atol=1e-6)


def test_what_cannot_be_followed_is_one_line(tmp_path: Path) -> None:
    for number, some in enumerate((STRANDS, STRANDS, STRANDS[:3]), 1):
        (tmp_path / f"a.{number}.ply").write_bytes(kit.ply(some))
    given = groom_kit.scene(tmp_path / "a.#.ply", solver="rod", rules=["emitter_motion"], detail=None)
    stage = SimulationStage(given, [3], None, RunOptions())
    stage.begin(2)
    with pytest.raises(UsageError, match="strands come and go"):
        stage.begin(3)
    with pytest.raises(UsageError, match=r"rod\.end: free"):
        moving(tmp_path, np.eye(3), ["emitter_motion"], solver="rod", **{"rod.end": "pinned"})
