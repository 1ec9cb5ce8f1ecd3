"""Strands that act on each other through a grid of their density and momentum: the rule `interaction` for rods.

Each step begins with a grid about the strands as they are, which knows nothing of the step before but its pressure.
Memory follows the box that the strands fill, not the space that they could reach.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import accumulate, pairwise
from operator import is_
from typing import TYPE_CHECKING, Any

import numba
import numpy as np
from numpy.typing import NDArray

from ...errors import UsageError
from ...groom.blocks import aligned
from ...groom.record import Groom
from ...scene.rule_type import touched
from ...solids import Solids
from ..rod.kernels.arrays import AXES, PACK, State
from ..rod.material import CELLS_ACROSS, MOST_SAMPLES, matter, require_cell, segments_along
from .kernels import records
from .kernels.forces import accelerate, act
from .kernels.nodes import note
from .kernels.pressure import find_room, work_shape
from .kernels.records import Lattice, Moving, Room
from .kernels.shelter import layer_size
from .kernels.transfer import deposit
from .strands import GridStrands, Moment, extent_of, lay_boxes, moved, samples_of

if TYPE_CHECKING:
    from ...scene.model import Scene

FRICTION_TIME = 0.01
"""Seconds in which `friction` is the share that is lost."""
EASE, MOST = 15.0, 0.5
"""Share of the density that pressure makes up for a second, and in a step, at the most."""
INSIDE = 5.0
"""Times as dense as the preset allows up to which strands may begin; a tie presses them to four or five times that.
Where they begin closer, as from one point, they could not part at their roots, and pressure would burst them: they may
stay as dense as they are."""
NONE_MET = np.empty(0, np.float32), np.empty(0, np.int8), np.empty((2, 1), np.int32)
"""What `forces.act` takes where there are no solids."""
PARTS, SEGMENTS_A_PART = 16, 4_000
"""Parts that strands are cut into at the most, and segments of each at the least."""


class StrandGrid:
    """The grid of a scene's strands. Raises `UsageError` for cells that do not fit the groom."""

    def __init__(self, scene: Scene, groom: Groom, parameters: Any, positions: NDArray[Any], dtype: Any) -> None:
        self.where = f"{scene.label or scene.source or 'scene'}: rule interaction"
        self.scene = scene
        self.friction = parameters.friction
        n = scene.emitter.particles - 1
        stands_for = scene.children.count if scene.children else 1
        lengths = groom.lengths.astype(np.float64) / n
        packs = -(-groom.strands // PACK)
        self.stands_for = stands_for
        self.metres = metres = np.zeros((packs, PACK), np.float32)
        metres.reshape(-1)[: groom.strands] = lengths * stands_for
        self.extent = max(extent_of(positions), float(groom.lengths.max()))  # folded strands reach further
        self._thickness = 2 * matter(scene.rod)[1]
        self.cell = self._cell(parameters.cell, lengths)
        self.samples = samples_of(segments_along(scene.rod, n), float(lengths.max()) / self.cell)
        count = min(PARTS, max(1, groom.strands * len(self.samples.first) // SEGMENTS_A_PART))
        cuts = [*range(0, packs, -(-packs // count)), packs]
        self.parts = np.array([cuts[:-1], cuts[1:]]).T.copy()
        self.boxes = np.zeros((len(self.parts) + 1, records.BOX), np.int64)
        count = max(len(self.parts), numba.get_num_threads())
        self.scratch = aligned((count, records.ROWS, PACK), dtype), aligned((count, records.FOUND * PACK))
        self.strands = GridStrands(self.samples, n, metres, len(self.boxes), dtype)
        self.memory = np.empty((0, records.CELL), np.float32)
        self._cells = np.empty(0, np.float32)
        self.pressure: NDArray[Any] = np.zeros((0, 0, 0), np.float32)
        self._numbers: Any = np.empty(records.NUMBERS, np.float32)
        self._margin = 1 if touched(scene) else 0
        """Cells that the box of all has beside strands: closed ones lend theirs to open neighbours."""
        self._empty_grid()
        self._last_step = 0.0
        self.density = self.given_density = parameters.density
        """Greatest density, strands a square metre; None until the first step, where the preset gives none; greater
        than the preset's where strands begin more than `INSIDE` times as dense."""
        self._started = False
        self.found = 0.0
        """The greatest at the begin of the last step, strands a square metre."""
        self.given = np.zeros(3)
        """What solids by pressure, and less wind, have given to strands in this frame so far: metres times m/s."""

    def _cell(self, given: float | None, lengths: NDArray[np.float64]) -> float:
        if given is None:
            return max(self.extent / CELLS_ACROSS, float(lengths.max()) / MOST_SAMPLES)
        require_cell(self.scene, given, lengths, self.extent / CELLS_ACROSS)
        if given > self.extent:
            raise UsageError(
                f"{self.where}.cell: {given:g} m is larger than the groom, which is {self.extent:.3g} m wide; make it "
                f"smaller, such as {self.extent / CELLS_ACROSS:.2g}"
            )
        return float(given)

    def prepare(self, state: State, mass: NDArray[Any], roots: NDArray[Any], moment: Moment) -> None:
        """Set `State.acceleration` and `State.jolted` for a step. ``roots`` (P, 3 S): velocity of the roots in it, m/s.
        Where a coordinate is not finite there is no grid, and both are set to zero."""
        dt, strands = moment.step, self.strands
        moving = strands.moving(state, roots, mass)
        lattice = strands.lattice(self.cell, dt, self._last_step)
        note(moving, lattice, self.parts)
        if self._last_step == 0:  # nothing is known of a step before
            strands.others[...] = moving.nodes[:, :, AXES:]
        if not self._press(moving, lattice, moment):
            state.acceleration[...], state.jolted[...] = 0, 0
            self._last_step = 0.0
            return
        if not self._started and self.density is not None and self.found > INSIDE * self.density:
            self.density = self.found
            self.pressure[...] = 0
            self._press(moving, lattice, moment)
        self._started = True
        if moment.solids is not None or any(moment.wind):
            less, *back = self._others.sum((0, 2), dtype=np.float64)
            self.given += less * self._numbers[records.CHANGE : records.CHANGE + 3]
            self.given += float(self._numbers[records.SPEED] * self._numbers[records.FULL]) * np.array(back)
        self.density, self._last_step = self.found if self.density is None else self.density, dt
        given = self.boxes[-1], self.targets, self.scratch, strands.shares(lattice, mass)
        accelerate(moving, lattice, self.parts, *given, state.acceleration, strands.handed)

    def _press(self, moving: Moving, lattice: Lattice, moment: Moment) -> bool:
        """Set pressure, and what it does to cells, in a step; False where a coordinate is not finite."""
        if not self._lay(lattice):
            return False
        most = deposit(
            moving, lattice, self.parts, self.boxes, self.memory, self.scratch, self.targets, self.grid, self._most,
            self.near,
        )  # fmt: skip
        among = moment.solids is not None
        if moment.solids is not None:
            self._find_room(self.boxes[-1], moment.solids)
        self._set_numbers(0.0 if among else float(most) / self.cell**3, moment)
        room = self.room if any(moment.wind) else self._calm
        most_open = act(
            self.boxes[-1], self.grid, self.near, room, self._numbers, self._work, self._met if among else NONE_MET,
            self.pressure.reshape(-1), self.targets, self._others,
        )  # fmt: skip
        self.found = float(most_open if among else most) / self.cell**3
        return True

    def begin_frame(self) -> None:
        """Forget what strands have handed to each other."""
        self.strands.handed[...], self.given[...] = 0, 0

    def momentum(self) -> tuple[NDArray[np.float64], float]:
        """Return by how much all have changed the momentum of all in this frame so far, but for the wind that they take
        from each other and what solids push back, in metres times m/s; and the sizes of what each has got, added up."""
        rows = self.strands.handed.reshape(len(self.metres), records.HANDED, PACK).astype(np.float64)
        sums = np.einsum("pcs,ps->c", rows, self.metres.astype(np.float64))
        return sums[:3] - self.given, float(sums[3])

    def begin_anew(self) -> None:
        """Forget what moved strands in the last step, for they have been stopped or put elsewhere."""
        self._last_step = 0.0

    def _set_numbers(self, found: float, moment: Moment) -> None:
        """Set the numbers of a step, as `records.FULL` and the others; ``found``: the density that is greatest
        where none has been given or found before, 0 if it is not known."""
        dt, (x, y, z) = moment.step, moment.wind
        numbers: Any = memoryview(self._numbers)
        speed = math.sqrt(x * x + y * y + z * z)
        numbers[records.FULL] = (found if self.density is None else self.density) * self.cell**3
        numbers[records.RATIO], numbers[records.MOST] = dt / (2 * self.cell), min(EASE * dt, MOST)
        numbers[records.LOST] = 1 - (1 - self.friction) ** (dt / FRICTION_TIME)
        numbers[records.SPEED], numbers[records.STOP] = self.cell / dt, self._thickness / self.cell**2
        for axis, (wind, pull) in enumerate(zip(moment.wind, moment.gravity, strict=True)):
            numbers[records.WAY + axis] = wind / speed if speed > 0 else wind
            numbers[records.CHANGE + axis], numbers[records.FALL + axis] = dt * wind, dt * dt / self.cell * pull

    def state_arrays(self) -> dict[str, NDArray[Any]]:
        """Return what a step takes from the one before: pressure and its box; and the densities that are reported."""
        numbers = np.array([math.nan if self.density is None else self.density, self.found, self._last_step])
        pressure = {"free pressure": self.pressure.reshape(-1), "box": self.boxes[-1]}
        strands = {name: getattr(self.strands, name) for name in ("others", "pushed", "handed")}
        return {**pressure, **strands, "numbers": numbers, "given": self.given}

    def check(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Raise `ValueError` where pressure is not of its box."""
        size = state["box"][records.SIZE : records.SIZE + 3].tolist()
        if min(size) < 0 or math.prod(size) != len(state["free pressure"]):
            raise ValueError("its pressure is not of its box")

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Go on from such a state."""
        box = state["box"]
        self.boxes[-1] = box
        self.pressure = np.array(state["free pressure"]).reshape(box[records.SIZE : records.SIZE + 3][::-1])
        self._empty_grid()
        for name in ("others", "pushed", "handed"):
            getattr(self.strands, name)[...] = state[name]
        self.given[...] = state["given"]
        density, self.found, self._last_step = state["numbers"].tolist()
        self.density, self._started = None if math.isnan(density) else density, True

    def _empty_grid(self) -> None:
        """Make arrays for the box of all."""
        wide, high, deep = self.boxes[-1, records.SIZE : records.SIZE + 3].tolist()
        count = wide * high * deep
        margined, layers = work_shape(wide, high, deep), (4, layer_size(wide, high, deep))
        # of the first cell kernels load the one before it
        sizes = (
            records.LANES,
            records.CELL * count,
            records.CELL * count,
            7 * count,
            math.prod(margined),
            math.prod(layers),
        )
        if sum(sizes) > len(self._cells):  # fresh memory at every change of the box would cost a tenth of the step
            self._cells = aligned((int(1.2 * sum(sizes)),))
        ends = list(accumulate(sizes))
        grid, targets, room, work, of_layers = (self._cells[a:b] for a, b in pairwise(ends))
        self.grid, self.targets = grid.reshape(records.CELL, count), targets.reshape(count, records.CELL)
        self.near, self._most = np.empty((deep, high), np.bool_), np.empty((deep, high), np.float32)
        self.shares, *of_room = room.reshape(7, count)
        self.room = Room(*of_room)
        self.room.open[:], self.room.aperture[:] = 1, 1
        work[: None if wide % (2 * records.LANES) else len(work) // margined[0]] = (
            0  # pressure, and what pads the others
        )
        self._calm = self.room._replace(left=self.room.left[:0])
        self._others = np.zeros((deep, 4, records.LANES), np.float32)
        met = count if self._margin else 0
        self._met = self.shares, np.empty(met, np.int8), np.empty((2, met + 1), np.int32)
        along = np.arange(wide) + self.boxes[-1, records.LOW] + 0.5
        self._along = (self.cell * along).astype(np.float32)
        self._work = work.reshape(margined), np.empty((2, deep + 2, high + 2), np.uint64), of_layers.reshape(layers)
        self._outside: tuple[list[bytes], Any] = [], ()
        """What ``shares`` follows from: rows of cells that strands are near, and solids, with the data of shapes."""

    def _find_room(self, whole: NDArray[np.int64], met: Solids) -> None:
        """Find what solids ``met`` leave of the rows of cells that strands are near, kept for as long as neither
        changes."""
        parts: tuple[Any, ...] = self.near, *met
        rows, data = [one.tobytes() for one in parts[:6]], parts[6:]
        if rows != self._outside[0] or not all(map(is_, data, self._outside[1])):
            self._outside = rows, data
            self.shares[:] = 1
            find_room(whole, self.cell, met, self._along, self.near, self.shares)

    def _lay(self, lattice: Lattice) -> bool:
        """Set the boxes about the strands of each part and of all, and their origins; False where a coordinate is not
        finite. Raises `UsageError` where they take too many cells."""
        before = self.boxes[-1].copy()
        if not lay_boxes(self.strands.ends, self.parts, self.cell, self._margin, self.where, self.boxes):
            return False
        lattice.origins[...] = self.cell * (self.boxes[:, records.LOW : records.LOW + 3] + 0.5)
        count = self.boxes[-2, records.OFFSET] + self.boxes[-2, records.SIZE : records.SIZE + 3].prod()
        if count > len(self.memory):
            self.memory = aligned((int(count * 1.2), records.CELL))
        if not np.array_equal(before, self.boxes[-1]):
            self.pressure = moved(self.pressure, before, self.boxes[-1])
            self._empty_grid()
        return True
