"""The production solver: inextensible rods with mass and bending stiffness, solved implicitly.

See `kernels/rod.py` for the model. A rod's shape at rest does not depend on the time step, and hardly on the number of
particles. Of a scene's rules it takes emitter motion, gravity, wind (whose strength is here the speed of the air in
m/s) and collision; elasticity and stiffness are its own: edges keep their length exactly, and bending follows from the
material. Twist is not represented.
"""

from __future__ import annotations

import math
from functools import cache
from operator import sub
from typing import TYPE_CHECKING, Any

import numba
import numpy as np
from numpy.typing import NDArray

from ..blocks import aligned, lanes
from ..constants import VECTOR, W
from ..errors import UsageError
from ..groom.record import Groom
from ..scene.model import Rod
from ..scene.motion import Pose, emitter_pose
from .kernels import rod_step, rod_tension, work_queue
from .kernels.records import DRAG, NUMBERS, POSE, STEP, Flags, Forcing, Material, State
from .kernels.rod_scratch import PACK
from .material import TORSION, matter_along, needs_double, stiffness
from .rest_shape import carried, coiled, straight, unit_edges
from .rod_others import code_among
from .sag_free import Held, hold
from .solver import Solver
from .surroundings import Surroundings, gravity

if TYPE_CHECKING:
    from ..scene.model import Scene

SHORT_MOST = 12
"""Segments up to which positions, in single precision, tell how far edges are from their length."""
TELEPORT = 2.0
"""Roots that move further than so many strand lengths in one step have not moved: they have been put elsewhere."""
ENOUGH = {(False, False): 1.8e-3, (True, False): 2e-6, (False, True): 1e-10, (True, True): 1e-12}
"""Error of |e|² at which iterations stop, as `kernels.rod_newton` measures it, for (BDF2, double precision asked for):
where motion is calmed down anyway, less will do, and of most strands the error is far less than of the worst."""
WORTH = 4_000
"""Segments of work that another thread is called for: waking it takes some hundredths of a millisecond."""
MOMENT = 1e-6
"""Seconds in which nothing moves but what is put elsewhere."""
STEADY = {False: 0.25, True: 0.5}
"""Of a step, the least inner damping of grooms with coils, with BDF2 where True: what rest shapes ask of the edges that
carry them is taken from before the step, which without that rocks tight curls."""
MOVED = ("emitter_motion", "gravity", "wind", "collision")
ITS_OWN = ("elasticity", "stiffness")


class RodSolver(Solver):
    """Strands as rods. Their state is ``edges``, ``velocity`` and ``push``, the acceleration by contact, (packs, N,
    3 `PACK`) each, in single or double precision."""

    def __init__(self, scene: Scene, groom: Groom) -> None:
        super().__init__(scene, groom)
        for use in scene.rules:
            if use.name not in MOVED + ITS_OWN:
                raise UsageError(
                    f"{scene.source or 'scene'}: rule {use.name}: the solver rod does not apply it; "
                    "take it out, or use solver: thesis"
                )
        rod: Rod = scene.rod
        n = scene.emitter.particles - 1
        mass, joint = matter_along(rod, n)
        lengths = groom.lengths.astype(np.float64) / n
        fall = float(np.linalg.norm(gravity(scene))) / (scene.time.fps * scene.time.substeps) ** 2
        double = rod.precision == "double" or needs_double(rod, joint, lengths, fall)
        self.dtype: Any = np.float64 if double else np.float32
        self.mass, self.joint = mass.astype(self.dtype), joint.astype(self.dtype)
        self.stiffness = self._packed(stiffness(rod, lengths)[:, None])
        self.own_lengths = self._packed(lengths[:, None])
        self.surroundings = Surroundings(scene, self.dtype)
        self.carried = any(use.name == "emitter_motion" for use in scene.rules)
        self._still = emitter_pose(scene.emitter, 0.0)
        self.pose = self._pose(0.0)
        self.edges = aligned((len(self.own_lengths), n, 3 * PACK), self.dtype)
        edges, mended = unit_edges(groom, n)
        if rod.rest == "sag_free":  # not even what single precision is off by may move it
            mended = mended or self.dtype == np.float32
            edges = [edge / np.linalg.norm(edge, axis=1, keepdims=True) for edge in edges]
        turn = np.array(self.pose.rotation)
        for j, edge in enumerate(edges):
            self.edges[:, j] = self._packed(edge @ turn.T)
            if mended:
                self.positions[:, j + 2] = self.positions[:, j + 1] + np.tile(self.lengths, 3) * lanes(edge @ turn.T)
        self.rows = self.positions  # in the solver's own precision
        if self.dtype != np.float32:
            self.rows = aligned(self.positions.shape, self.dtype)
            self.rows[...] = self.positions
        self.velocity = aligned(self.edges.shape, self.dtype)
        self.tension = aligned((len(self.edges), n, PACK), self.dtype)
        bdf2 = rod.integrator == "bdf2"
        self.second = bdf2
        self.before = aligned((self.edges if bdf2 else self.edges[:1]).shape, self.dtype)
        self.moved = aligned(self.before.shape, self.dtype)
        self.roots = self._packed(groom.roots)
        self.directions = self._packed(groom.directions)
        self.outermost = float(np.linalg.norm(groom.roots, axis=1).max())
        self.reach = TELEPORT * float(groom.lengths.max())
        self.curled = rod.rest == "sag_free" or not (
            rod.rest == "straight" or straight([groom.directions.astype(np.float64), *edges])
        )
        self.bends = aligned((len(self.edges) if self.curled else 1, n + 1, 3 * PACK), self.dtype)
        self.twist = aligned((len(self.bends), n, PACK), self.dtype)
        coils = self.curled and coiled(edges)
        self.steady, self.torsion = STEADY[bdf2] if coils else 0.0, TORSION[coils]
        if self.curled:
            self._bend(groom.directions.astype(np.float64), np.stack(edges), lengths)
        some = self.surroundings.any_solids
        self.push = aligned((self.edges if some else self.edges[:1]).shape, self.dtype)
        self.touching = aligned((len(self.push), PACK), self.dtype)
        self.residuals = np.zeros(self.own_lengths.shape, self.dtype)
        self.last_step = 0.0
        self.place_roots(1)
        self._prepare(min(numba.get_num_threads(), 1 + groom.strands * n // WORTH))

    def _packed(self, rows: NDArray[np.floating]) -> NDArray[Any]:
        """(strands, k) values a strand -> (packs, k * `PACK`), as the kernel reads them."""
        return lanes(rows, self.dtype, PACK)

    def _prepare(self, workers: int) -> None:
        """What every step hands on in the same way: arrays that it changes in place, and numbers that stay."""
        around, rod, n = self.surroundings, self.scene.rod, self.edges.shape[1]
        self._pull = tuple(around.gravity.tolist())
        self._bounds = (
            ENOUGH[self.second, rod.precision == "double"], 4 * float(np.finfo(self.dtype).eps), self.torsion
        )  # fmt: skip
        self._gust = np.ones(self.own_lengths.shape, self.dtype)
        self._numbers = np.zeros(NUMBERS + POSE, self.dtype)
        self._burden, self._resisted = self.mass.copy(), 0.0
        self._code: int | None = None
        size = rod_tension.scratch_size(n) * VECTOR
        self.scratch = aligned((workers, size // self._numbers.itemsize), self.dtype)
        state = State(
            self.edges, self.velocity, self.before, self.moved, self.tension, self.push, self.touching, self.twist,
            self.rows, self.residuals,
        )  # fmt: skip
        material = Material(self.own_lengths, self.stiffness, self._burden, self.joint, self.bends)
        forcing = Forcing(self.roots, self.directions, self._gust, self._numbers[NUMBERS:], self._numbers[:NUMBERS])
        *solids, whole = around.solids(0.0, 0.0)
        self._arrays = (state, material, forcing), tuple(solids)  # whose addresses the descriptor holds
        flags = Flags(self.second, self.curled, around.any_solids, whole)
        self._descriptor = rod_step.descriptor_of(self.strands, n, rod.iterations, flags, self.scratch, *self._arrays)
        # lanes without a strand are copies of the last strand, and the queue leaves most of them alone
        last = self.rows[-1].reshape(-1, W)
        done = len(self.edges) * PACK - (len(self.rows) - 1) * W
        self._padding = last[:, done:], last[:, done - 1, None]

    def _pose(self, time: float) -> Pose:
        """The emitter's pose; at rest where no rule carries the roots along."""
        if self.carried and self.scene.emitter.keys:
            return emitter_pose(self.scene.emitter, self.scene.time.pose_time(time))
        return self._still

    def step(self, time: float, dt: float) -> None:
        """One step of length ``dt`` seconds that ends at ``time``; nothing where ``dt`` is 0."""
        if dt <= 0:
            return
        pose = self._pose(time)
        restart = dt != self.last_step
        elsewhere = self._teleported(pose)
        if elsewhere:
            self._carry(pose)
        rod, around = self.scene.rod, self.surroundings
        if around.any_solids and (elsewhere or self.last_step == 0):
            self._put_outside(time - dt)
        second = self.second and not restart and not elsewhere
        h = 2 * dt / 3 if second else dt
        gust = around.gust(time, self.positions)
        if gust is not None:
            self._gust[...] = gust.reshape(-1, PACK)[: len(self._gust)]
        around.solids(time, dt, pose if self.carried else None)
        self._share_out(
            pose, h, *self._pull, *around.air(time), rod.drag, max(rod.damping, self.steady * h),
            1 / 3 if second else 0.0, rod.friction,
        )  # fmt: skip
        if self.rows is not self.positions:
            self.positions[...] = self.rows
        self.pose, self.last_step = pose, dt

    def _share_out(self, pose: Pose, *numbers: float) -> None:
        """Run the step with the first of its numbers, on all threads that there is work for."""
        now, past = _flat(pose), _flat(self.pose)
        self._numbers[:] = (*numbers, *self._bounds, *now, *map(sub, now, past))
        resisted = self._numbers[STEP] * self._numbers[DRAG]
        if resisted != self._resisted:
            np.multiply(self.mass, 1 + resisted, out=self._burden)  # with what drag resists
            self._resisted = resisted
        self._descriptor[work_queue.NEXT] = 0
        if self._code is None:  # not compiled before anything moves, which need not be
            double, others = self.dtype == np.float64, self.surroundings.others
            self._code = code_among(others, double) if others else _code(double)
        # frames that are drawn meanwhile have the other threads: to take those away would have this one wait for them
        workers = len(self.scratch)
        if workers > 1:
            workers = min(workers, numba.get_num_threads())
        work_queue.share_out(self._code, self._descriptor, workers)
        idle, last = self._padding
        if idle.size:
            np.copyto(idle, last)

    def _put_outside(self, time: float) -> None:
        """Turn edges off solids at a time, and leave all at rest: what begins inside of one would leave it the faster
        the shorter the step, and how strands move would have no limit."""
        tension = self.tension.copy()
        self.surroundings.solids(time, 0.0)
        self._share_out(self.pose, MOMENT, *[0.0] * 10)
        self.tension[...] = tension
        for still in (self.velocity, self.before, self.moved, self.push, self.touching):
            still[...] = 0

    def _teleported(self, pose: Pose) -> bool:
        """Whether some root has moved further than it could have."""
        turned = math.hypot(*map(math.dist, pose.rotation, self.pose.rotation))
        if turned * self.outermost + math.dist(pose.translation, self.pose.translation) <= self.reach:
            return False
        turn = np.subtract(pose.rotation, self.pose.rotation)
        moved = np.subtract(pose.translation, self.pose.translation)
        way = np.einsum("cd,bdk->bck", turn, self.roots.reshape(-1, 3, PACK).astype(np.float64)) + moved[:, None]
        return bool(np.sqrt((way**2).sum(1).max()) > self.reach)

    def _carry(self, pose: Pose) -> None:
        """Take everything along rigidly and at rest."""
        turn = np.array(pose.rotation) @ np.array(self.pose.rotation).T
        centre, goal = np.array(self.pose.translation), np.array(pose.translation)
        edges = self.edges.reshape(*self.edges.shape[:2], 3, PACK)
        edges[...] = np.einsum("cd,bndk->bnck", turn, edges)
        self.velocity[...] = self.push[...] = self.touching[...] = 0
        for rows in [self.positions] if self.rows is self.positions else [self.positions, self.rows]:
            wide = rows.reshape(*rows.shape[:2], 3, W).astype(np.float64) - centre[:, None]
            rows[...] = (np.einsum("cd,bndk->bnck", turn, wide) + goal[:, None]).reshape(rows.shape)
        self.pose = pose

    def _bend(self, axes: NDArray[np.float64], edges: NDArray[np.float64], lengths: NDArray[np.float64]) -> None:
        """Set the rest bends of strands clamped along ``axes`` (strands, 3) whose ``edges`` are (N, strands, 3), in the
        emitter's frame."""
        bends = np.diff(np.concatenate([axes[None], edges]), axis=0)
        angles = np.zeros(edges.shape[:2])
        if self.scene.rod.rest == "sag_free":
            held = self._hold(axes, edges, lengths)
            bends, angles = bends - held.bends, held.twist
        first, local = carried(axes, edges, bends, angles)
        self.bends[:, 0] = self._packed(first)
        for j, bend in enumerate(local):
            self.bends[:, j + 1] = self._packed(bend)
            self.twist[:, j] = self._packed(angles[j][:, None])

    def _hold(self, axes: NDArray[np.float64], edges: NDArray[np.float64], lengths: NDArray[np.float64]) -> Held:
        """What holds these edges still under gravity; tension begins as it will be, and strands that are too soft
        become stiffer, as `advice.softness` tells."""
        pull = np.array(self.pose.rotation).T @ self.surroundings.gravity
        own = stiffness(self.scene.rod, lengths)
        # of numbers as the kernel reads them: what they are rounded by would be a load
        mass, joint = self.mass.astype(np.float64), self.joint.astype(np.float64)
        held = hold(axes, edges, mass, joint, own, self.torsion, pull / lengths[:, None])
        for j, tension in enumerate(held.tension):
            self.tension[:, j] = self._packed(tension[:, None])
        if (held.stiffness > own).any():
            self.stiffness = self._packed(held.stiffness[:, None])
        return held

    def place_roots(self, frame_number: int) -> None:
        """By the emitter's pose at a frame, to the very bits of a step that ends there."""
        turn, moved = (np.array(part, self.dtype) for part in self._pose((frame_number - 1) / self.scene.time.fps))
        roots = _turned(turn, self.roots) + moved[:, None]
        before = roots - self.own_lengths[:, None] * _turned(turn, self.directions)
        for row, at in enumerate((before, roots)):
            self.positions[:, row] = lanes(at.transpose(0, 2, 1).reshape(-1, 3)[: self.strands])

    def errors(self, frame: int) -> dict[str, float | None]:
        """As for any solver, but stretch of long strands is that of the solver's own edges: of positions in single
        precision the last digit is 6e-8 m a metre from the origin."""
        out = super().errors(frame)
        if self.edges.shape[1] > SHORT_MOST or self.dtype == np.float64:
            edges = self.edges.reshape(*self.edges.shape[:2], 3, PACK)
            out["stretch_max"] = float(np.abs(np.sqrt((edges**2).sum(2)) - 1).max())
        return out

    def strand_residuals(self) -> NDArray[np.floating]:
        """Errors of an edge's length that the last step's iterations left, as shares: made exact after."""
        return self.groom.emitted(self.residuals.reshape(-1)[: self.strands])


def _flat(pose: Pose) -> tuple[float, ...]:
    """(12,) a pose's rotation by rows and its translation."""
    a, b, c = pose.rotation
    return (*a, *b, *c, *pose.translation)


def _turned(turn: NDArray[Any], rows: NDArray[Any]) -> NDArray[Any]:
    """Vectors (packs, 3 `PACK`) turned by a matrix, (packs, 3, `PACK`), in the order of sums that the kernel has."""
    x, y, z = rows.reshape(-1, 3, PACK).transpose(1, 0, 2)
    return np.stack([a * x + b * y + c * z for a, b, c in turn], 1)


@cache
def _code(double: bool) -> int:
    """Address of the step, compiled for a precision."""
    return work_queue.address(rod_step.double if double else rod_step.single)
