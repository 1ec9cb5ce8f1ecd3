"""Strands that act on each other through a grid of their density and momentum: the rule `interaction` for rods.

Each step begins with a grid about the strands as they are, which knows nothing of the step before but its pressure.
Memory follows the box that the strands fill, not the space that they could reach.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import accumulate, pairwise
from operator import is_
from typing import TYPE_CHECKING, Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from ...constants import W
from ...errors import UsageError
from ...groom.blocks import aligned, on_large_pages
from ...groom.record import Groom
from ...jit.tasks import Tasks
from ...scene.rule_type import touched
from ...solids import Solids
from ..rod.kernels.arrays import AXES, PACK, State
from ..rod.material import cell_of, matter, segments_along
from .kernels import records, step
from .kernels.pressure import find_room, work_shape
from .kernels.records import FIRST, LANES, LOW, OFFSET, SIZE, Moving, Room, Samples, samples_of

if TYPE_CHECKING:
    from ...scene.model import Scene

FRICTION_TIME = 0.01
"""Seconds in which `friction` is the share that is lost."""
EASE, MOST = 15.0, 0.5
"""Share of the density that pressure makes up for a second, and in a step, at the most."""
INSIDE = 5.0
"""Times as dense as allowed up to which strands may begin; denser ones could not part, and stay as they are."""
LEAST_ROOM = np.float32(0.5)
"""Share of a cell that counts as outside of solids at the least, where its density is reported."""
PARTS, SEGMENTS_A_PART = 16, 4_000
"""Parts that strands are cut into at the most, and segments of each at the least."""


MOST_CELLS = 4_000_000
"""Of the box about the strands: some 120 bytes each, 470 MB."""


class Moment(NamedTuple):
    """The step that strands are prepared for."""

    step: float
    """Its length, seconds."""
    wind: tuple[float, float, float]
    """Acceleration of strands at rest by the open wind, m/s²."""
    gravity: tuple[float, float, float]
    """m/s²."""
    solids: Solids | None
    """Those that strands collide with, at its end."""


class StrandGrid:
    """The grid of a scene's strands. Raises `UsageError` for cells that do not fit the groom."""

    def __init__(self, scene: Scene, groom: Groom, parameters: Any, positions: NDArray[Any], dtype: Any) -> None:
        self.where = f"{scene.label or scene.source or 'scene'}: rule interaction"
        self.scene = scene
        self.friction = parameters.friction
        n = scene.emitter.particles - 1
        lengths = groom.lengths.astype(np.float64) / n
        packs = -(-groom.strands // PACK)
        self.metres = np.zeros((packs, PACK), np.float32)
        self.metres.reshape(-1)[: groom.strands] = lengths * (scene.children.count if scene.children else 1)
        low, high = ends_of(positions)
        self.extent = max(
            float((high.max(0) - low.min(0)).max()), float(groom.lengths.max())
        )  # folded strands reach further
        self._thickness = 2 * matter(scene.rod)[1]
        self.cell = cell_of(scene, groom, parameters.cell, self.extent)
        kind = np.dtype(dtype).type
        found = samples_of(segments_along(scene.rod, n), float(lengths.max()) / self.cell, kind)
        blocks, count = -(-groom.strands // W), groom.strands * len(found[0]) // SEGMENTS_A_PART
        cuts = [*range(0, blocks, -(-blocks // min(PARTS, max(1, count)))), blocks]
        self.parts = np.minimum(np.array([cuts[:-1], cuts[1:]]).T * (W // PACK), packs)
        self.boxes = np.zeros((len(self.parts) + 1, records.BOX), np.int64)
        count = max(len(self.parts), numba.get_num_threads())
        self.scratch = aligned((count, records.ROWS, PACK), dtype), aligned((count, records.FOUND * PACK))
        self._origins = np.empty((len(self.boxes), 3), dtype)
        self.samples = Samples(*found, kind(1 / self.cell), self._origins, kind(0), kind(1))
        self.unloaded, self.pushed = (on_large_pages((packs, n, AXES), dtype) for _ in range(2))
        """As `Moving` has them."""
        self.memory = np.empty(0, np.float32)
        self._tasks = Tasks(step.run)
        self._cells = np.empty(0, np.float32)
        self.pressure: NDArray[Any] = np.zeros((0, 0, 0), np.float32)
        self._numbers: Any = np.empty(records.NUMBERS, np.float32)
        self._margin = 1 if touched(scene) else 0
        """Cells that the box of all has beside strands, which solids may close: beside the box all is open."""
        self._empty_grid()
        self._last_step = 0.0
        self.density = self.given_density = parameters.density
        """Greatest density, strands a square metre; None until the first step, where the preset gives none; greater
        than the preset's where strands begin more than `INSIDE` times as dense."""
        self._started = False
        self.found = 0.0
        """The greatest at the begin of the last step, strands a square metre."""

    def prepare(self, state: State, mass: NDArray[Any], roots: NDArray[Any], moment: Moment) -> None:
        """Set `State.acceleration` and `State.jolted` for a step. ``roots`` (P, 3 S): velocity of the roots in it, m/s.
        Where a coordinate is not finite there is no grid, and both are set to zero."""
        if not self._place(state.positions):
            state.acceleration[...], state.jolted[...] = 0, 0
            self._last_step = 0.0
            return
        if self._last_step == 0:  # nothing is known of a step before
            self.unloaded[...] = state.velocity
        moving = Moving(state.positions, state.velocity, self.unloaded, self.pushed, state.jolted, roots, self.metres)
        kind, whole = type(self.samples.inverse), self.boxes[-1]
        again = kind(moment.step / self._last_step if self._last_step else 1.0)
        samples = self.samples._replace(step=kind(moment.step), again=again)
        particles = samples.first[:, None] + np.arange(-1, samples.weights.shape[1] - 1)
        shares = (samples.mass / samples.step)[:, None] * samples.weights
        shares /= mass[np.clip(particles, 0, len(mass) - 1)]
        room = self.room if any(moment.wind) else self._calm
        cells = step.Cells(
            self.parts, self.boxes, self.memory, *self.scratch, self.grid, self._most, self.near, room, self._numbers,
            *self._work, self.pressure.reshape(-1), self.targets, shares, state.acceleration,
        )  # fmt: skip
        self._tasks.bind((moving, samples, cells))
        parts, layers = len(self.parts), int(whole[SIZE + 2])
        self._run(step.DEPOSIT, parts)
        self._run(step.MERGE, layers)
        most = self._mark_near()
        self.pressure[~self.near] = 0
        if moment.solids is not None:
            self._find_room(whole, moment.solids)
            most = (self.grid[records.MASS] / np.maximum(self.room.open, LEAST_ROOM)).max()
        self.found = float(most) / self.cell**3
        if not self._started and (self.density is None or self.found > INSIDE * self.density):
            self.density = self.found
        self._started, self._last_step = True, moment.step
        self._set_numbers(moment)
        self._run(step.EXCESS, layers)
        self._run(step.PRESS, step.PRESSES if len(room.left) else 1)
        self._run(step.TARGETS, layers)
        self._run(step.ACCELERATE, parts)

    def _run(self, phase: int, tasks: int) -> None:
        self._tasks.run(tasks, min(tasks, numba.get_num_threads()), phase)

    def _mark_near(self) -> float:
        """Set whether a row of cells or one of those around it has strands; return the most metres in a cell."""
        deep, high = self.near.shape
        some = np.zeros((deep + 2, high + 2), np.bool_)
        some[1:-1, 1:-1] = self._most > 0
        self.near[...] = False
        for o, n in np.ndindex(3, 3):
            self.near |= some[o : o + deep, n : n + high]
        return float(self._most.max())

    def begin_anew(self) -> None:
        """Forget what moved strands in the last step, for they have been stopped or put elsewhere."""
        self._last_step = 0.0

    def _set_numbers(self, moment: Moment) -> None:
        """Set the numbers of a step, as `records.FULL` and the rest."""
        dt, (x, y, z) = moment.step, moment.wind
        numbers: Any = memoryview(self._numbers)
        speed = math.sqrt(x * x + y * y + z * z)
        numbers[records.FULL] = self.density * self.cell**3
        numbers[records.RATIO], numbers[records.MOST] = dt / (2 * self.cell), min(EASE * dt, MOST)
        numbers[records.LOST] = 1 - (1 - self.friction) ** (dt / FRICTION_TIME)
        numbers[records.SPEED], numbers[records.STOP] = self.cell / dt, self._thickness / self.cell**2
        for axis, (wind, pull) in enumerate(zip(moment.wind, moment.gravity, strict=True)):
            numbers[records.WIND + axis] = wind / speed if speed > 0 else wind
            numbers[records.CHANGE + axis], numbers[records.FALL + axis] = dt * wind, dt * dt / self.cell * pull

    def state_arrays(self) -> dict[str, NDArray[Any]]:
        """Return what a step takes from the one before: pressure and its box; and the densities that are reported."""
        numbers = np.array([math.nan if self.density is None else self.density, self.found, self._last_step])
        pressure = {"free pressure": self.pressure.reshape(-1), "box": self.boxes[-1]}
        return {**pressure, "unloaded": self.unloaded, "pushed": self.pushed, "numbers": numbers}

    def check(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Raise `ValueError` where pressure is not of its box."""
        size = state["box"][SIZE : SIZE + 3].tolist()
        if min(size) < 0 or math.prod(size) != len(state["free pressure"]):
            raise ValueError("its pressure is not of its box")

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Go on from such a state."""
        box = state["box"]
        self.boxes[-1] = box
        self.pressure = np.array(state["free pressure"]).reshape(box[SIZE : SIZE + 3][::-1])
        self._empty_grid()
        self.unloaded[...], self.pushed[...] = state["unloaded"], state["pushed"]
        density, self.found, self._last_step = state["numbers"].tolist()
        self.density, self._started = None if math.isnan(density) else density, True

    def _empty_grid(self) -> None:
        """Make arrays for the box of all."""
        wide, high, deep = self.boxes[-1, SIZE : SIZE + 3].tolist()
        count, margined, columns = wide * high * deep, work_shape(wide, high, deep), len(Room._fields)
        # of the first cell kernels load the one before it
        sizes = LANES, records.CELL * count, records.CELL * count, columns * count, math.prod(margined)
        if sum(sizes) > len(self._cells):  # fresh memory at every change of the box would cost a tenth of the step
            self._cells = aligned((int(1.2 * sum(sizes)),))
        ends = list(accumulate(sizes))
        grid, targets, room, work = (self._cells[a:b] for a, b in pairwise(ends))
        self.grid, self.targets = grid.reshape(records.CELL, count), targets
        self.near, self._most = np.empty((deep, high), np.bool_), np.empty((deep, high), np.float32)
        self.room = Room(*room.reshape(columns, count))
        self.room.open[:], self.room.aperture[:] = 1, 1
        self._calm = self.room._replace(left=self.room.left[:0])
        work[:] = 0
        self._work = work.reshape(margined), np.empty((2, deep + 2, high + 2), np.bool_)
        self._along = self.cell * (np.arange(wide, dtype=np.float32) + self.boxes[-1, LOW] + 0.5)
        self._along = self._along.astype(np.float32)
        self._outside: tuple[list[bytes], Any] = [], ()
        """What ``room`` follows from: rows of cells that strands are near, and solids, with the data of shapes."""

    def _find_room(self, whole: NDArray[np.int64], met: Solids) -> None:
        """Find what solids ``met`` leave of the rows of cells that strands are near, cached for as long as neither
        changes."""
        parts: tuple[Any, ...] = self.near, *met
        rows, data = [one.tobytes() for one in parts[:6]], parts[6:]
        if rows != self._outside[0] or not all(map(is_, data, self._outside[1])):
            self._outside = rows, data
            self.room.open[:], self.room.aperture[:] = 1, 1
            find_room(whole, self.cell, met, self._along, self.near, self.room.open, self.room.aperture)

    def _place(self, positions: NDArray[Any]) -> bool:
        """Set the boxes about the strands of each part and of all, and their origins; False where a coordinate is not
        finite. Raises `UsageError` where they take too many cells."""
        before = self.boxes[-1].copy()
        if not place_boxes(positions, self.parts, self.cell, self._margin, self.where, self.boxes):
            return False
        self._origins[...] = self.cell * (self.boxes[:, LOW : LOW + 3] + 0.5)
        count = self.boxes[-2, OFFSET] + self.boxes[-2, SIZE : SIZE + 3].prod()
        if records.CELL * count > len(self.memory):
            self.memory = aligned((records.CELL * int(count * 1.2),))
        if not np.array_equal(before, self.boxes[-1]):
            self.pressure = moved(self.pressure, before, self.boxes[-1])
            self._empty_grid()
        return True


def ends_of(positions: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return (blocks, 3) the least and the greatest coordinates of strands in blocks; NaN where one is."""
    rows = positions[:, 1:].reshape(len(positions), -1, 3, W)
    return rows.min((1, 3)), rows.max((1, 3))


def moved(values: NDArray[Any], before: NDArray[np.int64], box: NDArray[np.int64]) -> NDArray[Any]:
    """Return the values of cells in another box, 0 where they had none: (z, y, x)."""
    found = np.zeros(box[SIZE : SIZE + 3][::-1], values.dtype)
    if values.size:
        shift = (box[LOW : LOW + 3] - before[LOW : LOW + 3])[::-1]
        ends = list(zip(shift.tolist(), found.shape, values.shape, strict=True))
        here = tuple(slice(max(-d, 0), max(min(a, b - d), 0)) for d, a, b in ends)
        there = tuple(slice(max(d, 0), max(min(b, a + d), 0)) for d, a, b in ends)
        found[here] = values[there]
    return found


def place_boxes(
    positions: NDArray[Any], parts: NDArray[np.int64], cell: float, margin: int, where: str, boxes: NDArray[np.int64]
) -> bool:
    """Set the ``boxes`` (parts + 1, `BOX`) about the strands of each part, of whole blocks, and ``margin`` cells wider
    about all. Return False where a coordinate is not finite. Raises `UsageError` where they take too many cells.

    cell: side of a cell, metres; where: the rule, for the message."""
    least, greatest = ends_of(positions)
    first = parts[:, FIRST] * PACK // W
    low = np.floor(np.minimum.reduceat(least, first).astype(np.float64) / cell - 0.5)
    high = np.floor(np.maximum.reduceat(greatest, first).astype(np.float64) / cell - 0.5) + 1
    along = high.max(0) - low.min(0) + 1
    if not np.isfinite(along).all():
        return False
    if (cells := (along + 2 * margin).prod()) > MOST_CELLS:
        factor = 1.0
        while np.prod(np.ceil(along / factor) + 1 + 2 * margin) > MOST_CELLS:  # a flat groom has few across
            factor *= 1.05
        raise UsageError(
            f"{where}.cell: cells of {cell:.3g} m would be {cells:.3g} in the box about the strands, more than "
            f"{MOST_CELLS:,}; make them at least {1.05 * factor * cell:.2g}"
        )
    boxes[:-1, LOW : LOW + 3], boxes[-1, LOW : LOW + 3] = low, low.min(0) - margin
    boxes[:-1, SIZE : SIZE + 3], boxes[-1, SIZE : SIZE + 3] = high - low + 1, along + 2 * margin
    boxes[-1, SIZE] = -(-boxes[-1, SIZE] // LANES) * LANES
    counts = boxes[:-1, SIZE : SIZE + 3].prod(1)
    boxes[:-1, OFFSET] = np.cumsum(counts) - counts
    return True
