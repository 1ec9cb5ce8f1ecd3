"""The production solver: inextensible rods with mass and bending stiffness, solved implicitly.

See `kernels/rod.py` for the model. A rod's shape at rest does not depend on the time step, and hardly on the number of
particles. Of a scene's rules it applies emitter motion, gravity, wind (whose strength is here the speed of the air in
m/s), interaction, contact and collision. Elasticity and stiffness are its own: edges keep their length exactly, and
bending follows from the material, as does the twist of curled strands.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..blocks import lanes
from ..errors import UsageError
from ..groom.record import Groom
from ..scene.motion import Pose
from .contact.between_strands import StrandContact, in_parts
from .crowd import Crowd, Moment
from .kernels.records import AIR, FREE, LASTING, TOLERANCE, TURNED
from .kernels.rod_scratch import PACK
from .material import COIL_STEP, MOST_INNER
from .momentum import errors_between_strands
from .rod_coils import CoilSteps
from .rod_kernel import NOTHING, StepKernel
from .rod_motion import Motion, change_of
from .rod_numbers import StepNumbers
from .rod_pinned import TOLERANCE as PINNED_TOLERANCE
from .rod_pinned import Pins
from .rod_roots import Roots
from .rod_setup import (
    coil_rate,
    flags_of,
    forcing_of,
    hinged,
    material_of,
    matter_of,
    precision_of,
    rest_of,
    shape_of,
    state_of,
    world_edges,
)
from .rod_teleport import begin_before_roots, carry, stop, turned, velocity_of_roots
from .solver import Solver
from .surroundings import Surroundings, flat, pose_of
from .swing import parts, swing_rate

if TYPE_CHECKING:
    from ..scene.model import Scene

FEWEST_BY_EDGES = 12
"""Segments beyond which stretch is measured at the solver's own edges: positions in single precision do not tell."""
TOLERANCES = {False: 1.8e-3, True: 1e-12}
"""Error of |e|² at which iterations stop, as `kernels.rod_newton` measures it; True: where double precision is asked
for. Of most strands the error is far less than of the worst."""
APPLIED = ("emitter_motion", "gravity", "wind", "interaction", "contact", "collision")
REPLACED = ("elasticity", "stiffness")
"""Rules that the solver applies, and those that it has its own form of."""


class RodSolver(Solver):
    """Strands as rods, with ``state``, ``material`` and ``forcing`` as `kernels.records` describes them, in single or
    double precision: double where single would not be enough, or where ``double`` asks for it, to measure with.
    ``mass`` (N,) is that of particles without what drag adds. Raises `UsageError` for a rule that the solver does not
    apply."""

    def __init__(self, scene: Scene, groom: Groom, double: bool = False) -> None:
        super().__init__(scene, groom)
        for use in scene.rules:
            if use.name not in APPLIED + REPLACED:
                raise UsageError(
                    f"{scene.source or 'scene'}: rule {use.name}: the solver rod does not apply it; "
                    "take it out, or use solver: thesis"
                )
        rod, matter = scene.rod, matter_of(scene, groom)
        self.dtype = np.float64 if double else precision_of(scene, matter)
        self.surroundings = Surroundings(scene, self.dtype)
        self.motion = Motion(scene, groom, self.surroundings)
        self.pose = self.motion.pose(0.0)
        shape = shape_of(scene, groom, self.dtype)
        matter = hinged(scene, matter, shape)
        if shape.mended:
            for j, edge in enumerate(world_edges(shape, self.pose)):
                self.positions[:, j + 2] = self.positions[:, j + 1] + np.tile(self.lengths, 3) * lanes(edge)
        rest = rest_of(scene, shape, matter, self.pose, self.dtype)
        between = [use.parameters for use in scene.rules if use.name == "interaction"]
        self.crowd = Crowd(scene, groom, between[0], self.positions, self.dtype) if between else None
        touching = [use.parameters for use in scene.rules if use.name == "contact"]
        self.contact = StrandContact(scene, groom, touching[0]) if touching else None
        flags = flags_of(scene, shape, self.surroundings, self.deforming is not None)
        self.curled = flags.curled
        self._coil_rate = coil_rate(scene, rest, shape)
        self._swing_rate = swing_rate(scene, matter.lengths, rest.stiffness, shape, np.array(self.pose.rotation))
        self.state = state_of(self.positions, world_edges(shape, self.pose), rest, flags, self.dtype)
        self.material = material_of(matter, rest, self.dtype)
        self.forcing = forcing_of(groom, len(self.state.edges), self.dtype, flags, rod, shape.coiled)
        self.forcing.numbers[TOLERANCE] = TOLERANCES[double]
        self.forcing.numbers[LASTING] = self.contact is not None
        self.mass = self.material.mass.copy()
        self._gravity = tuple(self.surroundings.gravity.tolist())
        arrays = self.state, self.material, self.forcing
        self._air, self._change = memoryview(self.forcing.numbers)[AIR : AIR + 3], memoryview(self.forcing.pose)
        coils = CoilSteps(*arrays[1:], self.state.edges) if shape.curled else None
        self.numbers = StepNumbers(rod, *arrays[1:], self.mass, self._gravity, coils)
        self.pins = Pins(self.state, self.material, self.forcing, self.pose) if rod.end == "pinned" else None
        self.roots = Roots(self.deforming, self.strands, rod, arrays, shape.curled)
        self._moment = 0.0, 0.0  # end of the step that is made, and its length, seconds
        self._steady = not self._coil_rate and self.contact is None and self.deforming is None
        """Whether a step is one of the kernel's."""
        self._alone = self.crowd is self.contact is self.deforming is None
        """Whether nothing but the emitter, air and solids drives strands."""
        self._last_step = 0.0
        self.place_roots(1)
        self.kernel = StepKernel(self.strands, rod.iterations, flags, arrays, self.surroundings)

    def state_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the rods' state, where their roots are, and the poses of the last step."""
        state = {f"state {name}": one for name, one in self.state._asdict().items() if one is not self.positions}
        last = {"last": np.array([self._last_step, *flat(self.pose)]), "poses": self.surroundings.last_poses()}
        crowd = {} if self.crowd is None else self.crowd.state_arrays()
        found = {} if self.contact is None else self.contact.state_arrays()
        return {**super().state_arrays(), **state, **self.roots.state_arrays(), **last, **crowd, **found}

    def check(self, state: Mapping[str, NDArray[Any]], frame: int) -> None:
        """Raise `ValueError` for a state that is none of a frame."""
        super().check(state, frame)
        if self.crowd is not None:
            self.crowd.check(state)

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Go on from such a state."""
        self.roots.restore(state)
        super().restore(state)
        for name, one in self.state._asdict().items():
            if one is not self.positions:
                one[...] = state[f"state {name}"]
        last = state["last"].tolist()
        self._last_step, self.pose = last[0], pose_of(last[1:])
        self.surroundings.set_last_poses(state["poses"])
        if self.crowd is not None:
            self.crowd.restore(state)
        if self.contact is not None:
            self.contact.restore(state)

    def hold_tip(self, at: tuple[float, float, float], seconds: float = 1.0) -> None:
        """Bring the tips of strands to a place (metres, in the emitter's frame) in so many seconds, and pin them."""
        self.pins = self.pins or Pins(self.state, self.material, self.forcing, self.pose)
        self.pins.bring(at, seconds)

    def begin_frame(self) -> None:
        """As for any solver."""
        if self.crowd is not None:
            self.crowd.begin_frame()
        if self.contact is not None:
            self.contact.begin_frame()

    def announce(self, ends: Sequence[float], dt: float) -> None:
        """As for any solver."""
        if self._steady:
            count = parts(self._swing_rate, dt)
            inner = [end - left * dt / count for end in ends for left in range(count - 1, -1, -1)]
            self.motion.announce(inner, dt / count, self.pose)

    def step(self, time: float, dt: float) -> None:
        """A step of ``dt`` seconds that ends at ``time``, in several where coils or swings ask for it; nothing where it
        is 0."""
        count = parts(self._swing_rate, dt)
        if count == 1 and self._steady:
            self._step(time, dt)
            return
        count = min(max(count, math.ceil(self._coil_rate * dt / COIL_STEP)), MOST_INNER)
        halved = math.ceil(math.log2(count))  # no part is the shorter for coils
        for left in range(count - 1, -1, -1):
            end, part = time - left * dt / count, dt / count
            if self.contact is None:
                self._step(end, part)
            else:
                in_parts(self, self._step, end, part, halved)

    def _step(self, time: float, dt: float) -> bool:
        """One step of ``dt`` seconds that ends at ``time``; nothing where ``dt`` is 0. Return False where it is too
        long for what strands do to each other."""
        if dt <= 0:
            return True
        rod, around, moved = self.scene.rod, self.surroundings, self.motion.step(time, dt, self.pose)
        pose = moved.pose
        if moved.jumps:
            carry(self.state, self.positions, self.pose, pose)
            self.pose = pose
            if self.crowd is not None:
                self.crowd.begin_anew()
        if around.any_solids and (moved.jumps or self._last_step == 0):
            self._put_outside(time - dt)
        self.roots.deform(time, self.pose)
        self.roots.begin_frames(self.pose, pose)
        bdf2 = dt == self._last_step and not moved.jumps
        gust = around.gust(time, self.positions)
        if gust is not None:
            self.forcing.gust[...] = gust.reshape(-1, PACK)[: len(self.forcing.gust)]
        around.solids(time, dt, self.motion.outer(pose), moved.solids)
        self._moment, beside = (time, dt), NOTHING
        if self.crowd is not None:
            strength = rod.drag * (float(gust.mean()) if gust is not None else 1.0)
            x, y, z = moved.air
            moment = Moment(time, dt, (strength * x, strength * y, strength * z), self._gravity, around.packed())
            roots = velocity_of_roots(self.forcing, moved.change, dt, self.crowd.strands.roots)
            beside = self.crowd.prepare(
                self.state, self.mass, roots, moment, self.contact is None and self.pins is None
            )
        self.numbers.set(dt, bdf2, self.pins is not None)
        self._air[:] = moved.wind
        still = self._alone and not (moved.jumps or any(moved.change[TURNED:]) or any(moved.air))
        self.forcing.numbers[FREE] = still and self.pins is None
        if self.contact is None:
            self._run(pose, moved.change, beside)
            short = True
        else:
            short = self.contact.step(partial(self._run, pose, moved.change), dt, self)
        if self.state.positions is not self.positions:
            self.positions[...] = self.state.positions
        if self.roots.hinged:
            begin_before_roots(self.positions)
        self.pose, self._last_step = pose, dt
        return short

    def _run(self, pose: Pose, change: memoryview, beside: tuple[int, ...] = NOTHING) -> None:
        """Run the kernel to a pose of the emitter, with its ``change`` as `Forcing.pose`."""
        if self.pins is not None:
            self.forcing.numbers[TOLERANCE] = min(self.forcing.numbers[TOLERANCE], PINNED_TOLERANCE)
            self.pins.aim(self.state, self.forcing, (self.pose, pose), *self._moment)
        self._change[:] = change
        self.kernel.run(beside)

    def _put_outside(self, time: float) -> None:
        """Turn edges out of solids at a time, and leave all at rest: a strand that begins inside would leave the faster
        the shorter the step, and its motion would have no limit."""
        state = self.state
        tension = state.tension.copy()
        self.forcing.drift[...] = 0
        self.surroundings.solids(time, 0.0)
        stop(state.crowd, state.jolted)
        self.numbers.set_moment(self.pins is not None)
        self._run(self.pose, change_of(self.pose, self.pose, self.dtype))
        state.tension[...] = tension
        stop(state.velocity, state.before, state.ahead, state.moved, state.push, state.touching)
        if self.crowd is not None:
            self.crowd.begin_anew()

    def place_roots(self, frame: int) -> None:
        """Put the first two rows where they are at a frame, to the bits of a step that ends there."""
        self.roots.deform((frame - 1) / self.scene.time.fps, self.pose)
        turn, moved = (np.array(part, self.dtype) for part in self.motion.pose((frame - 1) / self.scene.time.fps))
        roots = turned(turn, self.forcing.roots) + moved[:, None]
        before = roots - self.material.lengths[:, None] * turned(turn, self.forcing.directions)
        for row, at in enumerate((before, roots)):
            self.positions[:, row] = lanes(at.transpose(0, 2, 1).reshape(-1, 3)[: self.strands])

    def take(self, frame: int, particles: NDArray[np.floating]) -> None:
        """As for any solver."""
        super().take(frame, particles)
        if self.roots.hinged:
            begin_before_roots(self.positions)

    def errors(self, frame: int) -> dict[str, float | None]:
        """As for any solver, but stretch of long strands is that of the solver's own edges: of positions in single
        precision the last digit is 6e-8 m a metre from the origin. `momentum.errors_between_strands` adds to them."""
        out = super().errors(frame)
        edges = self.state.edges
        if edges.shape[1] > FEWEST_BY_EDGES or self.dtype == np.float64:
            square = (edges.reshape(*edges.shape[:2], 3, PACK) ** 2).sum(2)
            out["stretch_max"] = float(np.abs(np.sqrt(square) - 1).max())
        return out | errors_between_strands(self)

    def strand_residuals(self) -> NDArray[np.floating]:
        """Errors of an edge's length that the last step's iterations left, as shares: made exact after."""
        return self.groom.emitted(self.state.residuals.reshape(-1)[: self.strands])
