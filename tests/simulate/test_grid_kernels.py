"""Kernels of the grid of strands: what solids leave of cells, donor cells, and pressure that throws no strand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from mesh_kit import mesh, obj
from rod_kit import rod_of
from strandcli.scene.motion import solid_pose
from strandcli.simulate.grid import strand_grid
from strandcli.simulate.grid.kernels.pressure import BETWEEN_ONLY, HASTENED, LED, WIDELY, limit
from strandcli.simulate.grid.kernels.records import (
    BETWEEN,
    CELL,
    FALL,
    FULL,
    LOW,
    MASS,
    MOMENTUM,
    MOST,
    NUMBERS,
    SIZE,
    SPEED,
    Room,
)
from strandcli.solids.shapes import other, other_code
from strandcli.study.stress import run as stress
from tests.simulate.test_grid import BALL, prepare

WIDE, HIGH, DEEP = 16, 7, 6
COUNT = WIDE * HIGH * DEEP
BOX = np.array([0, 0, 0, WIDE, HIGH, DEEP, 0])
LIVE = np.ones((DEEP + 2, HIGH + 2), np.bool_)


def made(share: float = 0.5) -> tuple[NDArray[np.float32], Room, NDArray[np.float32], NDArray[np.float32]]:
    """A grid with few strands at its sides, and far too much pressure within."""
    rng = np.random.default_rng(5)
    grid = rng.random((COUNT, CELL)).astype(np.float32).T.copy()
    z, y, x = np.meshgrid(*(np.arange(n) - (n - 1) / 2 for n in (DEEP, HIGH, WIDE)), indexing="ij")
    inner = np.exp(-(x**2 + y**2 + z**2) / 8).ravel().astype(np.float32)
    grid *= 0.01 + inner
    grid[MOMENTUM : MOMENTUM + 3] -= 0.5 * grid[MASS]
    empty = np.zeros(COUNT, np.float32)
    open = np.where(rng.random(COUNT) > 0.1, rng.uniform(0.3, 1, COUNT), 0).astype(np.float32)
    room = Room(open, np.sqrt(open), empty, empty, 0.2 * inner, empty, empty)
    numbers = np.zeros(NUMBERS, np.float32)
    numbers[FULL], numbers[SPEED], numbers[FALL + 1], numbers[MOST] = 0.3, 2.0, -0.3, share
    return grid, room, numbers, (30 * inner * (room.open > 0)).astype(np.float32)


def most(at: int, next: int, axis: int, grid: NDArray[np.float32], room: Room, numbers: NDArray[np.float32]) -> float:
    """By how much the pressure of a cell may be above that of a neighbour: plain numbers."""
    first, way = min(at, next), 1 if next > at else -1
    both = float(grid[MASS, at] + grid[MASS, next])
    m = float(WIDELY) * both + float(BETWEEN_ONLY) * float(grid[BETWEEN + axis, first])
    speed = way * float(grid[MOMENTUM + axis, at] + grid[MOMENTUM + axis, next]) / both / float(numbers[SPEED])
    share = float(numbers[MOST])
    led = max(float(HASTENED) * share**2 + max(-speed, 0), float(LED) * share - speed)
    led += max(-way * float(numbers[FALL + axis]), 0)
    face = float(room.aperture[at] * room.aperture[next])
    return m / float(numbers[FULL]) / face * led + max(float(room.held[at] - room.held[next]), 0)


@pytest.mark.parametrize("share", [0.5, 0.05])
def test_pressure_is_the_greatest_that_no_face_throws_strands_with(share: float) -> None:
    """Against the least sums along all ways between cells, in long and in short steps."""
    grid, room, numbers, found = made(share)
    pressure = found.copy()
    limit(BOX, grid, room, numbers, LIVE, pressure)
    wanted = found.astype(float)
    for _ in range(COUNT):
        before = wanted.copy()
        for at in range(COUNT):
            stride = 1
            for axis, size in enumerate((WIDE, HIGH, DEEP)):
                place = at // stride % size
                for next in [at - stride] * (place > 0) + [at + stride] * (place < size - 1):
                    if room.open[at] > 0 and room.open[next] > 0:
                        wanted[at] = min(wanted[at], wanted[next] + most(at, next, axis, grid, room, numbers))
                stride *= size
        if (before == wanted).all():
            break
    assert (wanted < 0.5 * found).sum() > 20
    np.testing.assert_allclose(pressure, wanted, rtol=1e-5, atol=1e-6)


@pytest.mark.long  # in double precision, which nothing else asks the grid's kernels for
def test_what_is_too_heavy_to_follow_is_not_pushed_without_end() -> None:
    """Tips a million times as heavy in steps of ten seconds: pushes grew a hundred thousandfold each, to infinity."""
    name = "rod/dt=10/n=3/L=1e6/tip=1e6/start=folded/between=grid-fine/twist=sag-free"
    (verdict,) = stress.perform(stress.named(name))
    assert verdict.verdict == "pass", verdict.why


D, ROWS, ACROSS, LENGTH = 0.002, 20, 20, 0.12
"""From strand to strand, metres; strands above and beside each other; their length, metres."""


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
