"""Kernels of the grid of strands: what solids leave of cells, and pushes that throw no strand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mesh_kit import mesh, obj
from rod_kit import rod_of
from strandcli.scene.motion import solid_pose
from strandcli.simulate.grid import strand_grid
from strandcli.simulate.grid.kernels.records import (
    LOW,
    SIZE,
)
from strandcli.solids.shapes import other, other_code
from strandcli.study.stress import run as stress
from tests.simulate.test_grid import BALL, prepare


@pytest.mark.long  # in double precision, which nothing else asks the grid's kernels for
def test_what_is_too_heavy_to_follow_is_not_pushed_without_end() -> None:
    """Tips a million times as heavy in steps of ten seconds: pushes grew a hundred thousandfold each, to infinity."""
    name = "rod/dt=10/n=3/L=1e6/tip=1e6/start=folded/between=grid-fine/twist=sag-free"
    (verdict,) = stress.perform(stress.named(name))
    assert verdict.verdict == "pass", verdict.why


def test_room_is_what_a_mesh_leaves_of_cells_and_is_kept_while_it_stands_still(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Against distances of one point after the other; where strands are, and nowhere else."""
    (tmp_path / "ball.obj").write_bytes(obj(mesh("ball")))
    solver = rod_of(
        f"emitter: {{{BALL}, strands: 40}}\nsolids: [{{kind: mesh, file: {tmp_path / 'ball.obj'}, scale: 0.1}}]\n"
        "rules: [interaction: {cell: 0.03}, collision]"
    )
    crowd, (solid,) = solver.grid, solver.scene.solids
    prepare(solver)
    box = crowd.boxes[-1]
    low, size = box[LOW : LOW + 3], box[SIZE : SIZE + 3]
    z, y, x = np.meshgrid(*(crowd.cell * (low[c] + np.arange(size[c]) + 0.5) for c in (2, 1, 0)), indexing="ij")
    row = other.pack([solid], [solid_pose(solid, solver.scene.emitter, 0.0)], np.float64)[0]
    far = other_code.depth(solid, row, np.stack([x, y, z], -1).reshape(-1, 3)).reshape(x.shape) / -crowd.cell
    beyond = 0.5 * np.maximum(1 - np.abs(far), 0) ** 2
    wanted = np.where(far > 0, 1 - beyond, np.where(far > -0.95, beyond, 0))
    wanted[~crowd.near] = 1
    assert 0 < crowd.near.sum() < crowd.near.size
    found = crowd.room.open.reshape(x.shape)
    inner = np.abs(far + 0.95) > 1e-4  # where it jumps rounding decides
    np.testing.assert_allclose(found[inner], wanted[inner], atol=1e-5)
    assert (found < 0.5).sum() > 20
    monkeypatch.setattr(strand_grid, "find_room", None)
    prepare(solver)
    np.testing.assert_array_equal(crowd.room.open.reshape(x.shape)[inner], found[inner])
    solver.surroundings._packed[-1][0, 0] += 0.01  # the ball moves
    with pytest.raises(TypeError, match="not callable"):
        prepare(solver)
