"""Children: drawn strands that are interpolated from simulated ones, the guides, with clumps, waves and an undercoat.

Film productions simulate one strand in twenty and interpolate the others, which costs little. Children are the strands
that the emitter would make if it made so many: a child's root, colour and length depend on the seed and its number
alone, and the guides are the first children. A child is interpolated from its three nearest guides with Shepard's
weights within the distance of the fourth (Franke and Nielson 1980); at a guide it is that guide.

Clumps are Voronoi cells of the first roots of the same sequence, each displaced at random by part of a cell's size, so
that they are not in rows. A clump belongs to the wider clump that contains its centre.
"""

from __future__ import annotations

import dataclasses
import math
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import solids
from ..constants import W
from ..errors import SimulationError
from ..scene.model import DiscShape, Emitter, MeshShape, PlaneShape
from ..scene.motion import emitter_pose
from ..scene.touched import touched
from . import fringe
from .deforming import Deforming, deforming
from .emit import emit, sides, stream
from .record import Groom, frame

if TYPE_CHECKING:
    from ..scene.model import Scene

PARENTS = 3
"""Guides of a child."""
STRAY_PULL = 0.15
"""Factor of a clump's strength for stray strands."""
WAVE_SPREAD = 0.35
"""Relative spread of wavelengths between clumps."""
SHARED = np.float32(0.4)
"""Share of a strand's tone that is that of its clumps."""
PLAIN = 4
"""Coordinates by which strands are compared, but on meshes."""
FACING = 0.1
"""What a difference of normals by 1 counts between strands on a mesh, as a share of its extent."""
RANDOM = 20
"""Number of the first random stream that is used here."""


class _Family(NamedTuple):
    """Constants of all children, as in `kernels.inputs`. A: children; C: levels of clumps; V: waves."""

    tones: NDArray[np.float32]
    roots: NDArray[np.float64]
    parents: NDArray[np.int32]
    """(A, 3)"""
    weights: NDArray[np.float32]
    """(A, 3)"""
    shares: NDArray[np.float32]
    """(A,) ratio of a child's length to that of its guides."""
    middles: NDArray[np.int32]
    """(C, A)"""
    pulls: NDArray[np.float32]
    """(C, A)"""
    radii: NDArray[np.float32]
    """(V, A) amplitude, metres; 0 for children without this wave."""
    phases: NDArray[np.float32]
    """(V, A) radians."""
    turns: NDArray[np.float32]
    """(V, A) radians a metre."""
    across: NDArray[np.float64]
    """(A, 3) unit vectors perpendicular to the direction of each child's clump, in the emitter's frame."""


class Children:
    """The children of a scene's guides."""

    def __init__(self, scene: Scene, groom: Groom) -> None:
        """``groom``: the guides, the first strands that the scene's emitter makes."""
        self.scene = scene
        self.groom = groom
        assert scene.children is not None
        self.settings = scene.children
        self.count = groom.strands * self.settings.count
        self._waves = [wave for wave in self.settings.waves if wave.radius > 0 and wave.share > 0]
        self.steps: int = self.settings.steps(scene.emitter.segment)
        """Parts into which a guide's segment is subdivided."""
        self._carried = any(use.name == "emitter_motion" for use in scene.rules)

    def select(self, positions: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.int32] | None]:
        """Return the tones of all children whose guides, positions (blocks, n + 1, 3 W), are finite, and their numbers,
        None for all. Raises `SimulationError` if there are none."""
        family = self.family
        if np.isfinite(positions).all():
            return family.tones, None
        rows = positions.reshape(*positions.shape[:2], 3, W)
        good = np.isfinite(rows).all((1, 2)).reshape(-1)[: self.groom.strands]
        sound: NDArray[np.bool_] = np.asarray(good[family.parents].all(1))
        alive = sound & sound[family.middles].all(0)
        if not alive.any():
            raise SimulationError("every child has a guide that is not finite; correct the preset")
        ids = np.flatnonzero(alive)
        return family.tones[ids], ids.astype(np.int32)

    def grow(
        self, positions: NDArray[np.float32], lengths: NDArray[np.float32], at: float, strands: int, scratch: Any,
        ids: NDArray[np.int32] | None = None,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:  # fmt: skip
        """Return the first ``strands`` children, or of those numbered ``ids``, at a time in seconds: positions
        (blocks, rows, 3 W) and segment lengths (blocks, W), from guides in the same layout."""
        from .kernels import children as kernel
        from .kernels.inputs import Clumps, Following, Guides, Waves

        family, steps = self.family, self.steps
        n = positions.shape[1] - 1
        particles = scratch.borrow("guides", (self.groom.strands, (n - 1) * steps + 2, 3), np.float32)
        kernel.refine(positions, np.int64(steps), particles)
        segments = (lengths.reshape(-1)[: self.groom.strands] / np.float32(steps)).astype(np.float32)
        rotation, shift = (np.array(part) for part in emitter_pose(self.scene.emitter, at if self._carried else 0.0))
        roots = family.roots if self._deforming is None else self._deforming.roots(at)
        roots = (roots @ rotation.T + shift).astype(np.float32)
        own = np.arange(strands, dtype=np.int32) if ids is None else ids[:strands]
        m = particles.shape[1] - 1
        way = np.linspace(0.0, 1.0, m)
        ramps = np.array([way**clump.shape for clump in self.settings.clumps], np.float32).reshape(-1, m)
        forms = np.array([[wave.round, wave.onset] for wave in self._waves], np.float32).reshape(-1, 2)
        across = (family.across @ rotation.T).astype(np.float32)
        blocks = -(-strands // W)
        out = scratch.borrow("children", (blocks, m + 1, 3 * W), np.float32)
        rest = scratch.borrow("children_lengths", (blocks, W), np.float32)
        kernel.grow(
            Guides(particles, segments),
            own,
            Following(family.parents, family.weights, roots, family.shares),
            Clumps(family.middles, family.pulls, ramps),
            Waves(forms, family.radii, family.turns, family.phases, across),
            self._solids(at),
            out,
            rest,
        )
        return out, rest

    def _solids(self, at: float) -> solids.Solids:
        return solids.pack_all(touched(self.scene), self.scene.emitter, at)

    @cached_property
    def every(self) -> Groom:
        """The children as emitted."""
        emitter, seed, edges = self.scene.emitter, self.scene.seed, self.settings.fringe
        moved = None
        if edges is not None:
            moved = partial(fringe.roots, edges, emitter, seed, guides=self.groom.strands)
        return emit(dataclasses.replace(emitter, strands=self.count), seed, fringe=moved)

    @cached_property
    def _deforming(self) -> Deforming | None:
        """The roots, where they move in the emitter's frame."""
        return deforming(self.scene, self.every)

    @cached_property
    def family(self) -> _Family:
        """Constants of all children, computed on first use."""
        scene, settings, count = self.scene, self.settings, self.count
        seed: int = scene.seed
        emitter, every = scene.emitter, self.every
        where = _places(emitter, every)
        parents, weights = self._parents(where)
        lots = stream(seed, RANDOM, count)
        levels = _Levels(emitter, settings.clumps, where, seed)
        pulls = [
            clump.strength
            * (1.0 - clump.variation * stream(seed, RANDOM + 10 + number, count)[levels.middles[number]])
            * np.where(lots < clump.stray, STRAY_PULL, 1.0)
            for number, clump in enumerate(settings.clumps)
        ]
        shares = 1.0 - settings.cut * stream(seed, RANDOM + 1, count)
        shares *= np.where(stream(seed, RANDOM + 2, count) < settings.undercoat, settings.undercoat_length, 1.0)
        if settings.fringe is not None:
            shares *= fringe.lengths(settings.fringe, seed, count, self.groom.strands)
        # strands of a clump share their waves
        clump_of = levels.middles[0] if settings.clumps else np.zeros(count, np.int32)
        radii, phases, turns = [], [], []
        for number, wave in enumerate(self._waves):
            each = stream(seed, RANDOM + 40 + 2 * number, count)[clump_of]
            own = stream(seed, RANDOM + 41 + 2 * number, count)
            radii.append(np.where(stream(seed, RANDOM + 100 + number, count) < wave.share, wave.radius, 0.0))
            phases.append(2 * np.pi * (each + wave.disorder * (own - 0.5)))
            longer = stream(seed, RANDOM + 80 + number, count)[clump_of] - 0.5
            turns.append(2 * np.pi / (wave.length * (1.0 + WAVE_SPREAD * longer)))
        tones = every.tones
        if settings.clumps and every.colours is None:
            tones = (1 - SHARED) * tones + SHARED * tones[levels.middles].mean(0)
        axes = every.directions.astype(np.float64)
        across = frame(axes[clump_of])[0]
        return _Family(
            tones,
            every.roots.astype(np.float64),
            parents,
            weights,
            np.maximum(shares, 1e-3).astype(np.float32),
            levels.middles,
            np.array(pulls, np.float32).reshape(-1, count),
            np.array(radii, np.float32).reshape(-1, count),
            np.array(phases, np.float32).reshape(-1, count),
            np.array(turns, np.float32).reshape(-1, count),
            across,
        )

    def _parents(self, where: NDArray[np.float32]) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """Return the guides of each child, (A, P), and their weights."""
        guides = self.groom.strands
        found, squares = _nearest(where, where[:guides], min(PARENTS + 1, guides))
        used = min(PARENTS, guides)
        d = np.sqrt(squares.astype(np.float64))
        reach = d[:, -1:] if found.shape[1] > used else np.full((len(d), 1), np.inf)
        d = np.maximum(d[:, :used], 1e-30)
        weights = np.maximum(1.0 / d - 1.0 / np.maximum(reach, 1e-30), 0.0) ** 2
        weights[weights.sum(1) == 0, 0] = 1.0
        weights /= weights.sum(1, keepdims=True)
        weights[:guides] = 0.0
        parents = np.ascontiguousarray(found[:, :used])
        parents[:guides, 0] = np.arange(guides)
        weights[:guides, 0] = 1.0
        # a guide of weight 0 must not matter, not even if it is NaN
        parents = np.where(weights > 0, parents, parents[:, :1])
        return self.groom.emitted(np.arange(guides, dtype=np.int32))[parents], weights.astype(np.float32)


class _Levels:
    """Nested levels of clumps."""

    def __init__(self, emitter: Emitter, clumps: tuple[Any, ...], where: NDArray[np.float32], seed: int) -> None:
        count = len(where)
        self.middles = np.zeros((len(clumps), count), np.int32)
        """(C, A) number of the child at the centre of each child's clump."""
        inner = np.arange(count)
        for number in range(len(clumps) - 1, -1, -1):
            size = clumps[number].size
            clump_count = min(max(round(_area(emitter) / size**2), 1), count)
            moved = where[:clump_count].copy()
            for c in range(3):
                lots = stream(seed, RANDOM + 60 + 3 * number + c, clump_count)
                moved[:, c] += (size * 0.9 * (lots - 0.5)).astype(np.float32)
            self.middles[number] = _nearest(where, moved, 1)[0][:, 0][inner]
            inner = self.middles[number]


def _nearest(
    points: NDArray[np.float32], others: NDArray[np.float32], many: int
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    from .kernels.alike import most_alike
    from .kernels.nearest import nearest

    found = np.empty((len(points), many), np.int32)
    squares = np.empty((len(points), many), np.float32)
    order = np.argsort(others[:, 0], kind="stable").astype(np.int32)
    search = nearest if points.shape[1] == PLAIN else most_alike
    search(points, np.ascontiguousarray(others[order]), order, found, squares)
    return found, squares


def _places(emitter: Emitter, every: Groom) -> NDArray[np.float32]:
    """Return the coordinates for distances between strands, (N, 4): roots, and the side of the parting, farther apart
    than any roots; on a mesh (N, 7): normals, too, so that strands on the other side of an ear are far away."""
    roots = every.roots
    apart = 10.0 * float(np.abs(roots).max())
    found: list[NDArray[Any]] = [roots, apart * sides(emitter, roots)]
    if isinstance(emitter.shape, MeshShape) and every.anchors is not None and emitter.tie is None:
        from .on_mesh import at_anchors, seedbed

        normals = at_anchors(seedbed(emitter.shape).mesh, every.anchors)[1]
        found.append(FACING * float(np.ptp(roots, axis=0).max()) * normals)
    return np.column_stack(found).astype(np.float32)


def _area(emitter: Emitter) -> float:
    """Return the area of the surface from which simulated strands begin, m²."""
    shape = emitter.shape
    if emitter.tie is not None:
        return math.pi * emitter.tie.radius**2
    if isinstance(shape, DiscShape):
        return math.pi * shape.radius**2
    if isinstance(shape, PlaneShape):
        return shape.width * shape.depth
    if isinstance(shape, MeshShape):
        from .on_mesh import seedbed

        return seedbed(shape).even
    return 2 * math.pi * shape.radius**2 * (1 - math.cos(math.radians(shape.cap)))
