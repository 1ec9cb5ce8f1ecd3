"""The grid's pressure against the greatest that throws no strand, which plain numbers find."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from strandcli.simulate.grid.kernels.pressure import BETWEEN_ONLY, HASTENED, LED, WIDELY, limit
from strandcli.simulate.grid.kernels.records import (
    BETWEEN,
    CELL,
    FALL,
    FULL,
    MASS,
    MOMENTUM,
    MOST,
    NUMBERS,
    SPEED,
    Room,
)

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
    first, sign = min(at, next), 1 if next > at else -1
    both = float(grid[MASS, at] + grid[MASS, next])
    m = float(WIDELY) * both + float(BETWEEN_ONLY) * float(grid[BETWEEN + axis, first])
    speed = sign * float(grid[MOMENTUM + axis, at] + grid[MOMENTUM + axis, next]) / both / float(numbers[SPEED])
    share = float(numbers[MOST])
    led = max(float(HASTENED) * share**2 + max(-speed, 0), float(LED) * share - speed)
    led += max(-sign * float(numbers[FALL + axis]), 0)
    face = float(room.aperture[at] * room.aperture[next])
    return m / float(numbers[FULL]) / face * led + max(float(room.carried[at] - room.carried[next]), 0)


@pytest.mark.parametrize("share", [0.5, 0.05])
def test_pressure_is_the_greatest_that_no_face_throws_strands_with(share: float) -> None:
    """Against the least sums along all paths between cells, in long and in short steps."""
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
