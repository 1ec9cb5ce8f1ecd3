"""Children: drawn strands that are interpolated from simulated ones, the guides, with clumps, waves and an undercoat.

Film productions simulate one strand in twenty and interpolate the rest, which costs little. Children are the strands
that the emitter would make if it made so many: a child's root, colour and length depend on the seed and its number
alone, and the guides are the first children. A child is interpolated from its three nearest guides with Shepard's
weights within the distance of the fourth (Franke and Nielson 1980); at a guide it is that guide.

Clumps are Voronoi cells of the first roots of the same sequence, each displaced at random by part of a cell's size, so
that they are not in rows. A clump belongs to the wider clump that contains its centre.
"""

from __future__ import annotations

import dataclasses
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import solids
from ..constants import VECTOR, W
from ..errors import SimulationError
from ..scene.motion import emitter_pose
from ..scene.rule_type import touched
from .deforming import Deforming, FileRoots, deforming
from .emit import emit
from .family import Family, family_of
from .record import Groom

if TYPE_CHECKING:
    from ..scene.model import Scene
    from .kernels.inputs import Clumps, Following, Guides, Waves


NUMBERS = VECTOR // 4
"""Numbers of a vector in single precision."""
NEAR = 512
"""Children about a point among which its nearest are looked for."""


class Leading(NamedTuple):
    """What children follow at a moment, as in `kernels.inputs`."""

    particles: int
    """Of each child."""
    guides: Guides
    following: Following
    clumps: Clumps
    waves: Waves
    solids: solids.Solids


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
        self._placed: tuple[Any, NDArray[np.float32], NDArray[np.float32]] | None = None
        self._rooted: tuple[NDArray[np.int32], NDArray[np.float32], NDArray[np.float32]] | None = None
        self._carried = any(use.name == "emitter_motion" for use in scene.rules)

    def select(self, positions: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """Return the tones of all children whose guides, positions (blocks, n + 1, 3 W), are finite, and their numbers
        in the order of emission. Neighbours are next to each other. Raises `SimulationError` if there are none."""
        family = self.family
        if np.isfinite(positions).all():
            return family.tones, family.ids
        rows = positions.reshape(*positions.shape[:2], 3, W)
        good = np.isfinite(rows).all((1, 2)).reshape(-1)[: self.groom.strands]
        sound: NDArray[np.bool_] = np.asarray(good[family.parents].all(1))
        alive = sound & sound[family.middles].all(0)
        if not alive.any():
            raise SimulationError("every child has a guide that is not finite; correct the preset")
        return family.tones[alive], family.ids[alive]

    def grow(
        self, positions: NDArray[np.float32], lengths: NDArray[np.float32], at: float, ids: NDArray[np.int32],
        scratch: Any,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:  # fmt: skip
        """Return the children numbered ``ids`` in the order of emission, at a time in seconds: positions (blocks, rows,
        3 W) and segment lengths (blocks, W), from guides in the same layout."""
        return self.grow_along(self.paths_of(positions, lengths, at, scratch), ids, scratch)

    def paths_of(
        self, positions: NDArray[np.float32], lengths: NDArray[np.float32], at: float, scratch: Any
    ) -> Leading:  # fmt: skip
        """Return what all children follow at a time in seconds, as `grow` has it. It is valid until it is asked for
        again with the same ``scratch``."""
        from .kernels import children as kernel
        from .kernels.inputs import Clumps, Following, Guides, Waves

        family, steps = self.family, self.steps
        m = (positions.shape[1] - 2) * steps + 1
        size = -(-3 * (m + 1) // NUMBERS) * NUMBERS
        offsets = scratch.borrow("guides", (self.groom.strands, size), np.float32)
        kernel.refine(positions, np.int64(steps), offsets)
        segments = (lengths.reshape(-1)[: self.groom.strands] / np.float32(steps)).astype(np.float32)
        roots, across = self._place(at)
        guides, following = Guides(offsets, segments), Following(*self._parents, roots, family.shares)
        numbers, centres = self._centres
        paths = scratch.borrow("clump_paths", (len(numbers), size), np.float32)
        kernel.write_paths(guides, following, numbers, paths)
        clumps = Clumps(centres, by_child(family.pulls[self._pulling]), self._ramps(m, size), paths)
        forms = np.array([[wave.round, wave.onset] for wave in self._waves], np.float32).reshape(-1, 2)
        waves = Waves(forms, by_child(family.radii), by_child(family.turns), by_child(family.phases), across)
        return Leading(m, guides, following, clumps, waves, self._solids(at))

    def grow_along(
        self, leading: Leading, ids: NDArray[np.int32], scratch: Any
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:  # fmt: skip
        """Return the children numbered ``ids`` as `grow` does, from what `paths_of` returned."""
        from .kernels import children as kernel

        blocks = -(-len(ids) // W)
        out = scratch.borrow("children", (blocks, leading.particles + 1, 3 * W), np.float32)
        rest = scratch.borrow("children_lengths", (blocks, W), np.float32)
        kernel.grow(leading.guides, self._standing[ids], *leading[2:], out, rest)
        return out, rest

    def _ramps(self, m: int, size: int) -> NDArray[np.float32]:
        """Return how much of their pull clumps have along a path of m particles, as `Clumps.ramps`."""
        share = np.linspace(0.0, 1.0, m)
        clumps = self.settings.clumps[self._pulling]
        ramps = np.zeros((len(clumps), size), np.float32)
        for ramp, clump in zip(ramps, clumps, strict=True):
            ramp[3 : 3 * (m + 1)] = np.repeat(share**clump.shape, 3)
        return ramps

    def roots(self, ids: NDArray[np.int32], at: float) -> NDArray[np.float32]:
        """Return the roots of the children numbered ``ids`` at a time in seconds, as rows (blocks, 2, 3 W) of which the
        second holds them: those of `grow` to the bit, since neither clumps nor waves move roots."""
        roots, _ = self._place(at)
        if self._rooted is None or self._rooted[0] is not ids or self._rooted[1] is not roots:
            count = len(ids)
            rows = np.zeros((-(-count // W), 2, 3, W), np.float32)
            placed = roots[self._standing[ids]]
            whole = count // W
            rows[:whole, 1] = placed[: whole * W].reshape(whole, W, 3).transpose(0, 2, 1)
            rows[whole:, 1, :, : count - whole * W] = placed[whole * W :].T
            self._rooted = ids, roots, rows.reshape(len(rows), 2, 3 * W)
        return self._rooted[2]

    def near(self, ids: NDArray[np.int32], own: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return which of the children numbered ``ids``, in their order, have the roots nearest to those of ``own``: at
        least about `NEAR` for each, block by block."""
        low, high = self._boxes
        standing = self._standing[ids]
        blocks = min(-(-NEAR * self.count // (W * len(ids))), len(low))
        marked = np.zeros(len(low), bool)
        for root in self.family.roots[standing[own]]:
            away = np.maximum(np.maximum(low - root, root - high), 0.0)
            marked[np.argpartition((away * away).sum(1), blocks - 1)[:blocks]] = True
        return np.flatnonzero(marked[standing // W])

    def _place(self, at: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return roots (A, 3), metres, and vectors across (A, 3), as in `family`, at a time in seconds, in the world.
        They are cached for as long as they stand still."""
        pose = emitter_pose(self.scene.emitter, at if self._carried else 0.0)
        if self._placed is None or self._placed[0] != pose or self._deforming is not None:
            family = self.family
            rotation, shift = (np.array(part) for part in pose)
            roots = family.roots if self._deforming is None else self._deforming.roots(at)[family.ids]
            self._placed = pose, _moved(roots, rotation, shift), _moved(family.across, rotation, np.zeros(3))
        return self._placed[1:]

    def _solids(self, at: float) -> solids.Solids:
        return solids.pack_all(touched(self.scene), self.scene.emitter, at)

    @cached_property
    def every(self) -> Groom:
        """The children as emitted."""
        return emit(dataclasses.replace(self.scene.emitter, strands=self.count), self.scene.seed)

    @cached_property
    def _standing(self) -> NDArray[np.int32]:
        """(A,) where each child, in the order of emission, is in `family`."""
        found = np.empty(self.count, np.int32)
        found[self.family.ids] = np.arange(self.count, dtype=np.int32)
        return found

    @cached_property
    def _pulling(self) -> slice:
        """The levels of clumps from the first to the last that pull any child; the rest are there for tones alone."""
        levels = np.flatnonzero([pulls.any() for pulls in self.family.pulls])
        return slice(levels[0], levels[-1] + 1) if len(levels) else slice(0)

    @cached_property
    def _centres(self) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """The children (K,) at the centres of clumps that pull, and which of them is at that of each child's (A, C)."""
        middles = self.family.middles[self._pulling]
        marked = np.zeros(self.count, bool)
        marked[middles] = True
        numbers = np.flatnonzero(marked).astype(np.int32)
        standing = np.cumsum(marked, dtype=np.int32) - np.int32(1)
        return numbers, by_child(standing[middles])

    @cached_property
    def _parents(self) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """Guides of children and their weights, as many as `PARENTS` even where there are fewer guides."""
        from .kernels.inputs import PARENTS

        parents, weights = self.family.parents, self.family.weights
        missing = PARENTS - parents.shape[1]
        if missing == 0:
            return parents, weights
        return np.pad(parents, ((0, 0), (0, missing)), "edge"), np.pad(weights, ((0, 0), (0, missing)))

    @cached_property
    def _boxes(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The bounding boxes (A / W, 3) of the roots of each W children of `family`: low and high corners."""
        begins = np.arange(0, self.count, W)
        roots = self.family.roots
        return np.minimum.reduceat(roots, begins, axis=0), np.maximum.reduceat(roots, begins, axis=0)

    @cached_property
    def _deforming(self) -> Deforming | FileRoots | None:
        """The roots, where they move in the emitter's frame."""
        return deforming(self.scene, self.every)

    @cached_property
    def family(self) -> Family:
        """Constants of all children, computed on first use."""
        return family_of(self.scene, self.groom, self.every, self._waves)


def _moved(
    points: NDArray[np.floating], rotation: NDArray[np.float64], shift: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Return points (A, 3), turned and then shifted. Not by BLAS: its threads wait for each other longer than this
    takes one of them, most of all where more threads draw frames beside it."""
    x, y, z = (np.asarray(points[:, c], np.float64) for c in range(3))
    out = np.empty(points.shape, np.float32)
    for c, (a, b, d) in enumerate(rotation):
        out[:, c] = x * a + y * b + z * d + shift[c]
    return out


def by_child(rows: NDArray[Any]) -> NDArray[Any]:
    """Return (A, n) of (n, A), those of a child next to each other however many there are: else kernels would be
    compiled for each order in memory."""
    return np.ascontiguousarray(rows.T)
