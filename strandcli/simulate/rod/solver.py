"""The production solver: inextensible rods with mass and bending stiffness, solved implicitly (`docs/solvers.md`).

Of a scene's rules it applies emitter motion, gravity, wind (whose strength is here the speed of the air in m/s),
interaction, contact and collision. Elasticity and stiffness are its own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...errors import UsageError
from ...groom.blocks import lanes
from ...groom.record import Groom
from ...scene.motion import Pose
from ..contact.between_strands import StrandContact, in_parts
from ..grid.strand_grid import Moment, StrandGrid
from ..health import errors_between_strands
from ..solver import Solver
from . import needs_double, setup
from .kernels.arrays import PACK, Step
from .material import torsion
from .roots import Roots, begin_before_roots, carry, stop, turned, velocity_of_roots
from .step import StepKernel
from .surroundings import Surroundings, change_of, flat, pose_of
from .swing import parts, swing_rate

if TYPE_CHECKING:
    from ...scene.model import Scene

FEWEST_BY_EDGES = 12
"""Segments beyond which stretch is measured at the solver's own edges: positions in single precision do not tell."""
TOLERANCES = {False: 1.8e-3, True: 1e-12}
"""Error of |e|² at which iterations stop, by whether double precision is asked for."""
MOMENT = 1e-6
"""Seconds in which nothing moves but what is put elsewhere."""
APPLIED = ("emitter_motion", "gravity", "wind", "interaction", "contact", "collision")
REPLACED = ("elasticity", "stiffness")
"""Rules that the solver applies, and those that it has its own form of."""


class RodSolver(Solver):
    """Strands as rods, with ``state``, ``material`` and ``drive`` as `kernels.arrays` describes them, in single or
    double precision: double where single would not be enough, or where ``double`` asks for it, to measure with. Raises
    `UsageError` for a rule that the solver does not apply."""

    def __init__(self, scene: Scene, groom: Groom, double: bool = False) -> None:
        super().__init__(scene, groom)
        for use in scene.rules:
            if use.name not in APPLIED + REPLACED:
                raise UsageError(
                    f"{scene.source or 'scene'}: rule {use.name}: the solver rod does not apply it; "
                    "take it out, or use solver: thesis"
                )
        rod, matter = scene.rod, setup.matter_of(scene, groom)
        exact = double or needs_double(scene, float(matter.lengths.min()))
        self.dtype = np.float64 if exact else np.float32
        self.surroundings = Surroundings(scene, self.dtype)
        self.pose = self.surroundings.pose(0.0)
        shape = setup.shape_of(scene, groom, self.dtype)
        if rod.root == "hinged":
            matter.joint[0] = setup.HINGE if shape.curled else 0.0
        if shape.mended:
            for j, edge in enumerate(setup.world_edges(shape, self.pose)):
                self.positions[:, j + 2] = self.positions[:, j + 1] + np.tile(self.lengths, 3) * lanes(edge)
        rest = setup.rest_of(scene, shape, matter, self.pose, self.dtype)
        between = [use.parameters for use in scene.rules if use.name == "interaction"]
        self.grid = StrandGrid(scene, groom, between[0], self.positions, self.dtype) if between else None
        touching = [use.parameters for use in scene.rules if use.name == "contact"]
        self.contact = StrandContact(scene, groom, touching[0]) if touching else None
        self.needs = setup.needs_of(scene, shape, self.surroundings, self.deforming is not None)
        self.curled = self.needs.curled
        self._swing_rate = swing_rate(scene, matter.lengths, rest.stiffness, shape, np.array(self.pose.rotation))
        self.state = setup.state_of(self.positions, setup.world_edges(shape, self.pose), rest, self.needs, self.dtype)
        self.material = setup.material_of(matter, rest, self.dtype)
        self.mass = self.material.mass.copy()
        """(N,) of particles, relative, without what pins add."""
        self.drive = setup.drive_of(groom, len(self.state.edges), self.dtype, self.needs)
        self._gravity = tuple(self.surroundings.gravity.tolist())
        arrays = self.state, self.material, self.drive
        self.pins: setup.Pins | None = None
        if rod.end == "pinned":
            self.pins = setup.Pins(self.state, self.material, self.drive, self.pose)
            self.material.mass[-1] *= setup.HEAVY
            self.needs = self.needs._replace(pinned=True)
        self.roots = Roots(self.deforming, groom, rod, arrays, shape.curled)
        self._tolerance = TOLERANCES[double]
        self._torsion = torsion(rod, shape.coiled), setup.ANCHOR if self.roots.hinged else setup.CLAMP
        self.now = self._numbers(MOMENT, False, (0.0, 0.0, 0.0), self.pose, change_of(self.pose, self.pose))
        """Numbers of the last step."""
        self._last_step = 0.0
        self.place_roots(1)
        self.kernel = StepKernel(self.strands, arrays, self.surroundings)

    def _numbers(
        self, dt: float, bdf2: bool, air: tuple[float, float, float], pose: Pose, change: tuple[float, ...]
    ) -> Step:
        """The numbers of a step of ``dt`` seconds to a ``pose``; nothing pulls where that is `MOMENT`."""
        rod, (torsion, root_twist), tolerance = self.scene.rod, self._torsion, self._tolerance
        if self.needs.pinned:
            tolerance = min(tolerance, setup.TOLERANCE)
        still, now = dt == MOMENT, flat(pose)
        rounding = 4 * float(np.finfo(self.dtype).eps)
        gravity, drag = ((0.0, 0.0, 0.0), 0.0) if still else (self._gravity, float(rod.drag))
        damping, friction = (0.0, 0.0) if still else (float(rod.damping), float(rod.friction))
        return Step(
            dt, bdf2, int(rod.iterations), tolerance, self._tolerance, rounding, gravity, air, drag, damping,
            friction, torsion, root_twist, now[:9], now[9:], change[:9], change[9:],
        )  # fmt: skip

    def state_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the rods' state, where their roots are, and the poses of the last step."""
        state = {f"state {name}": one for name, one in self.state._asdict().items() if one is not self.positions}
        last = {"last": np.array([self._last_step, *flat(self.pose)])}
        grid = {} if self.grid is None else self.grid.state_arrays()
        found = {} if self.contact is None else self.contact.state_arrays()
        return {**super().state_arrays(), **state, **self.roots.state_arrays(), **last, **grid, **found}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Go on from such a state."""
        if self.grid is not None:
            self.grid.check(state)
        self.roots.restore(state)
        super().restore(state)
        for name, one in self.state._asdict().items():
            if one is not self.positions:
                one[...] = state[f"state {name}"]
        last = state["last"].tolist()
        self._last_step, self.pose = last[0], pose_of(last[1:])
        if self.grid is not None:
            self.grid.restore(state)
        if self.contact is not None:
            self.contact.restore(state)

    def weight_tip(self, mass: float) -> None:
        """Add to the mass of tips, over that of a segment."""
        self.material.mass[-1] += mass

    def step(self, time: float, dt: float) -> None:
        """A step of ``dt`` seconds that ends at ``time``, in several where swings ask for it; nothing where it is 0."""
        count = parts(self._swing_rate, dt)
        for left in range(count - 1, -1, -1):
            end, part = time - left * dt / count, dt / count
            if self.contact is None:
                self._step(end, part)
            else:
                in_parts(self, self._step, end, part, math.ceil(math.log2(count)))

    def _step(self, time: float, dt: float) -> bool:
        """One step of ``dt`` seconds that ends at ``time``; nothing where ``dt`` is 0. Return False where it is too
        long for what strands do to each other."""
        if dt <= 0:
            return True
        around = self.surroundings
        pose = around.pose(time)
        jumps = self.roots.jump(self.pose, pose)
        if jumps:
            carry(self.state, self.positions, self.pose, pose)
            self.pose = pose
            if self.grid is not None:
                self.grid.begin_anew()
        if around.any_solids and (jumps or self._last_step == 0):
            self._put_outside(time - dt)
        self.roots.deform(time, self.pose)
        self.roots.begin_frames(self.pose, pose)
        gust = around.gust(time, self.positions)
        if gust is not None:
            self.drive.gust[...] = gust.reshape(-1, PACK)[: len(self.drive.gust)]
        around.solids(time, dt)
        bdf2 = dt == self._last_step and not jumps
        self.now = self._numbers(dt, bdf2, around.air(time), pose, change_of(self.pose, pose))
        if self.grid is not None:
            self._interact(self.grid, gust)
        if self.contact is None:
            self._run(pose)
            short = True
        else:
            short = self.contact.step(partial(self._run, pose), dt, self)
        if self.state.positions is not self.positions:
            self.positions[...] = self.state.positions
        if self.roots.hinged:
            begin_before_roots(self.positions)
        self.pose, self._last_step = pose, dt
        return short

    def _interact(self, grid: StrandGrid, gust: NDArray[Any] | None) -> None:
        """Have strands act on each other through their grid in a step."""
        now = self.now
        strength = now.drag * (float(gust.mean()) if gust is not None else 1.0)
        x, y, z = now.air
        wind = strength * x, strength * y, strength * z
        moment = Moment(now.duration, wind, self._gravity, self.surroundings.packed())
        roots = velocity_of_roots(self.drive, now.turned, now.shifted, now.duration)
        grid.prepare(self.state, self.material.mass, roots, moment)
        np.maximum(self.state.restart, self.state.jolted, out=self.state.restart)

    def _run(self, pose: Pose) -> None:
        """Run the kernel to a pose of the emitter."""
        if self.pins is not None:
            self.pins.aim(self.state, self.drive, (self.pose, pose))
        self.kernel.run(self.now, self.needs)

    def _put_outside(self, time: float) -> None:
        """Turn edges out of solids at a time, and leave all at rest: a strand that begins inside would leave the faster
        the shorter the step, and its motion would have no limit."""
        state = self.state
        tension = state.tension.copy()
        self.drive.drift[...] = 0
        self.surroundings.solids(time, 0.0)
        stop(state.acceleration, state.jolted)
        self.now = self._numbers(MOMENT, False, (0.0, 0.0, 0.0), self.pose, change_of(self.pose, self.pose))
        self._run(self.pose)
        state.tension[...] = tension
        stop(state.velocity, state.before, state.ahead, state.moved, state.force, state.restart)
        if self.grid is not None:
            self.grid.begin_anew()

    def place_roots(self, frame: int) -> None:
        """Put the first two rows where they are at a frame, to the bits of a step that ends there."""
        self.roots.deform((frame - 1) / self.scene.time.fps, self.pose)
        turn, moved = (np.array(part, self.dtype) for part in self.surroundings.pose((frame - 1) / self.scene.time.fps))
        roots = turned(turn, self.drive.roots) + moved[:, None]
        before = roots - self.material.lengths[:, None] * turned(turn, self.drive.directions)
        for row, at in enumerate((before, roots)):
            self.positions[:, row] = lanes(at.transpose(0, 2, 1).reshape(-1, 3)[: self.strands])

    def take(self, frame: int, particles: NDArray[np.floating]) -> None:
        """As for any solver."""
        super().take(frame, particles)
        if self.roots.hinged:
            begin_before_roots(self.positions)

    def stretch(self) -> float:
        """As for any solver, but of long strands at the solver's own edges: of positions in single precision the last
        digit is 6e-8 m a metre from the origin."""
        edges = self.state.edges
        if edges.shape[1] <= FEWEST_BY_EDGES and self.dtype != np.float64:
            return super().stretch()
        square = (edges.reshape(*edges.shape[:2], 3, PACK) ** 2).sum(2)
        return float(np.abs(np.sqrt(square) - 1).max())

    def errors(self, frame: int) -> dict[str, float | None]:
        """As for any solver, with those of `health.errors_between_strands`."""
        return super().errors(frame) | errors_between_strands(self)

    def strand_residuals(self) -> NDArray[np.floating]:
        """Errors of an edge's length that the last step's iterations left, as shares: made exact after."""
        return self.groom.emitted(self.state.residuals.reshape(-1)[: self.strands])
