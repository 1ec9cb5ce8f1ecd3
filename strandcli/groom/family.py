"""What children have for life: guides, clumps, waves, lengths and colours (see `strandcli.groom.children`).
Guides of strands and the middles of their locks are nearest neighbours among roots.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..jit.array_cache import Arrays, cached_arrays
from ..scene.model import DiscShape, Emitter, MeshShape, PlaneShape
from .blocks import spatial_order
from .emit import sides, stream
from .kernels.inputs import PARENTS
from .record import Groom, frame

if TYPE_CHECKING:
    from ..scene.model import Scene, Wave
    from .kernels.nearest import Cells

STRAY_PULL = 0.15
"""Factor of a clump's strength for stray strands."""
WAVE_SPREAD = 0.35
"""Relative spread of wavelengths between clumps."""
SHARED = np.float32(0.4)
"""Share of a strand's tone that is that of its clumps."""
LEVELS = ("middles", "pulls", "radii", "phases", "turns")
"""Arrays of a family that have a row for each level or wave, and those of a child next to each other."""
FACING = 0.1
"""What a difference of normals by 1 counts between strands on a mesh, as a share of its extent."""
RANDOM = 20
"""Number of the first random stream that is used here."""


class Family(NamedTuple):
    """Constants of all children, as in `kernels.inputs`, neighbours next to each other.

    A: children; C: levels of clumps; P: guides of each child; V: waves.
    """

    ids: NDArray[np.int32]
    """(A,) number of each in the order of emission."""
    tones: NDArray[np.float32]
    """(A,) in [−1, 1): deviation of each strand's colour from the mean."""
    roots: NDArray[np.float64]
    """(A, 3) metres, in the emitter's frame."""
    parents: NDArray[np.int32]
    """(A, P) numbers of the guides of each child."""
    weights: NDArray[np.float32]
    """(A, P) weights of these guides, whose sum is 1."""
    shares: NDArray[np.float32]
    """(A,) ratio of a child's length to that of its guides."""
    middles: NDArray[np.int32]
    """(C, A) where the child at the centre of each child's clump is here."""
    pulls: NDArray[np.float32]
    """(C, A) share by which the distance to that child is reduced at the tip."""
    radii: NDArray[np.float32]
    """(V, A) amplitude, metres; 0 for children without this wave."""
    phases: NDArray[np.float32]
    """(V, A) radians."""
    turns: NDArray[np.float32]
    """(V, A) radians a metre."""
    across: NDArray[np.float64]
    """(A, 3) unit vectors perpendicular to the direction of each child's clump, in the emitter's frame."""

    def of(self, order: NDArray[np.int32]) -> Family:
        """Return the children in another order; ``order`` (A,): where each is here."""
        standing = np.empty_like(order)
        standing[order] = np.arange(len(order), dtype=np.int32)
        moved = {name: one[:, order] if name in LEVELS else one[order] for name, one in self._asdict().items()}
        return self._replace(**moved | {"middles": standing[moved["middles"]]})


def family_of(scene: Scene, groom: Groom, every: Groom, waves: Sequence[Wave]) -> Family:
    """Return the constants of children. ``groom``: the guides; ``every``: the children as emitted, the guides first;
    ``waves``: those that move anything. They are cached from one run to the next."""
    settings, where, count = scene.children, places_of(scene.emitter, every), every.strands
    assert settings is not None
    levels, moved, used = len(settings.clumps), len(waves), min(PARENTS, groom.strands)
    small, whole = np.float32, np.int32
    like: Arrays = {
        name: np.broadcast_to(np.zeros((), kind), shape) for name, kind, shape in (
            ("ids", whole, count), ("tones", every.tones.dtype, count), ("parents", whole, (count, used)),
            ("weights", small, (count, used)), ("shares", small, count), ("middles", whole, (count, levels)),
            ("pulls", small, (count, levels)), ("radii", small, (count, moved)), ("phases", small, (count, moved)),
            ("turns", small, (count, moved)), ("across", np.float64, (count, 3)),
        )
    }  # fmt: skip
    given = [
        asdict(settings), [asdict(wave) for wave in waves], scene.seed, _area(scene.emitter), groom.strands,
        every.colours is None, where, groom.emitted(np.arange(groom.strands, dtype=np.int32)), every.tones,
        every.directions, every.roots,
    ]  # fmt: skip
    code = CODE
    arrays = cached_arrays("family", code, given, like, lambda: _cached_of(_made(scene, groom, every, waves, where)))
    found = {name: one.T if name in LEVELS else one for name, one in zip(like, arrays, strict=True)}
    return Family(roots=every.roots[found["ids"]].astype(np.float64), **found)


def _cached_of(family: Family) -> list[NDArray[Any]]:
    """Return the arrays that are cached, as they lie in memory: all but the roots, which are those emitted."""
    arrays = family._asdict()
    del arrays["roots"]
    return [np.ascontiguousarray(one.T if name in LEVELS else one) for name, one in arrays.items()]


def _made(scene: Scene, groom: Groom, every: Groom, waves: Sequence[Wave], where: NDArray[np.float32]) -> Family:
    """As `family_of`; ``where``: from `places_of`."""
    settings, emitter, count = scene.children, scene.emitter, every.strands
    assert settings is not None
    seed: int = scene.seed
    parents, weights = parents_of(where, groom)
    lots = stream(seed, RANDOM, count)
    middles = _middles(emitter, settings.clumps, where, seed)
    pulls = [
        clump.strength
        * (1.0 - clump.variation * stream(seed, RANDOM + 10 + number, count)[middles[number]])
        * np.where(lots < clump.stray, STRAY_PULL, 1.0)
        for number, clump in enumerate(settings.clumps)
    ]
    shares = 1.0 - settings.cut * stream(seed, RANDOM + 1, count)
    shares *= np.where(stream(seed, RANDOM + 2, count) < settings.undercoat, settings.undercoat_length, 1.0)
    # strands of a clump share their waves
    clump_of = middles[0] if settings.clumps else np.zeros(count, np.int32)
    radii, phases, turns = [], [], []
    for number, wave in enumerate(waves):
        each = stream(seed, RANDOM + 40 + 2 * number, count)[clump_of]
        own = stream(seed, RANDOM + 41 + 2 * number, count)
        radii.append(np.where(stream(seed, RANDOM + 100 + number, count) < wave.share, wave.radius, 0.0))
        phases.append(2 * np.pi * (each + wave.disorder * (own - 0.5)))
        longer = stream(seed, RANDOM + 80 + number, count)[clump_of] - 0.5
        turns.append(2 * np.pi / (wave.length * (1.0 + WAVE_SPREAD * longer)))
    tones = every.tones
    if settings.clumps and every.colours is None:
        tones = (1 - SHARED) * tones + SHARED * tones[middles].mean(0)
    axes = every.directions.astype(np.float64)
    across = frame(axes[clump_of])[0]
    emitted = Family(
        np.arange(count, dtype=np.int32),
        tones,
        every.roots.astype(np.float64),
        parents,
        weights,
        np.maximum(shares, 1e-3).astype(np.float32),
        middles,
        np.array(pulls, np.float32).reshape(-1, count),
        np.array(radii, np.float32).reshape(-1, count),
        np.array(phases, np.float32).reshape(-1, count),
        np.array(turns, np.float32).reshape(-1, count),
        across,
    )
    return emitted.of(spatial_order(every.roots))


def parents_of(where: NDArray[np.float32], groom: Groom) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Return the guides of each child, (A, P), and their weights."""
    guides = groom.strands
    parents, weights = shepard(where, where[:guides], PARENTS)
    weights[:guides] = 0.0
    parents[:guides, 0] = np.arange(guides)
    weights[:guides, 0] = 1.0
    # a guide of weight 0 must not matter, not even if it is NaN
    parents = np.where(weights > 0, parents, parents[:, :1])
    return groom.emitted(np.arange(guides, dtype=np.int32))[parents], weights.astype(np.float32)


def _middles(emitter: Emitter, clumps: tuple[Any, ...], where: NDArray[np.float32], seed: int) -> NDArray[np.int32]:
    """Return the number (C, A) of the child at the centre of each child's clump, of nested levels of clumps."""
    count = len(where)
    middles = np.zeros((len(clumps), count), np.int32)
    inner = np.arange(count)
    for number in range(len(clumps) - 1, -1, -1):
        size = clumps[number].size
        clump_count = min(max(round(_area(emitter) / size**2), 1), count)
        moved = where[:clump_count].copy()
        for c in range(3):
            lots = stream(seed, RANDOM + 60 + 3 * number + c, clump_count)
            moved[:, c] += (size * 0.9 * (lots - 0.5)).astype(np.float32)
        middles[number] = nearest_of(where, moved, 1)[0][:, 0][inner]
        inner = middles[number]
    return middles


def places_of(emitter: Emitter, every: Groom) -> NDArray[np.float32]:
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


A_CELL = 2.0
"""Points a cell of the grid in which they are looked for, on average over its area."""
CODE = (__name__, f"{__package__}.kernels.nearest")
"""Modules that neighbours follow from."""
ROUNDING = 1e-6
"""Of the grid's extent and distance from the origin; positions have single precision."""


def shepard(
    points: NDArray[np.float32], candidates: NDArray[np.float32], most: int
) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Return the numbers (N, P) of the nearest P <= ``most`` of candidates (G, D) to each of points (N, D), and
    Shepard's weights of them within the distance of the next one (Franke and Nielson 1980), whose sum is 1."""
    found, squares = nearest_of(points, candidates, min(most + 1, len(candidates)))
    used = min(most, len(candidates))
    d = np.sqrt(squares.astype(np.float64))
    reach = d[:, -1:] if found.shape[1] > used else np.full((len(d), 1), np.inf)
    weights = np.maximum(1.0 / np.maximum(d[:, :used], 1e-30) - 1.0 / np.maximum(reach, 1e-30), 0.0) ** 2
    weights[weights.sum(1) == 0, 0] = 1.0
    weights /= weights.sum(1, keepdims=True)
    return np.ascontiguousarray(found[:, :used]), weights


def nearest_of(
    points: NDArray[np.float32], candidates: NDArray[np.float32], many: int
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Return the numbers (N, many) int32 of the nearest of candidates (G, D) to each of points (N, D), nearest first,
    and their squared distances, float32; many <= G, D >= 3. All coordinates count; the
    search is by the first three."""
    from .kernels.nearest import nearest

    found = np.empty((len(points), many), np.int32)
    squares = np.empty((len(points), many), np.float32)
    nearest(points, cells_of(candidates), found, squares)
    return found, squares


def cells_of(points: NDArray[np.float32]) -> Cells:
    """Return points (G, D) by the cells of a grid over those two of their first three coordinates that vary most."""
    from .kernels.nearest import Cells

    places = points[:, :3].astype(np.float64)
    low, extent = places.min(0), np.ptp(places, axis=0)
    b, a = (int(axis) for axis in np.argsort(extent, kind="stable")[1:])
    most = max(float(extent[a]), 1e-30)
    # as many cells as points have use for, and of a line no rows of them
    size = max(math.sqrt(most * float(extent[b]) * A_CELL / len(points)), most * A_CELL / len(points))
    columns, rows = (max(math.ceil(float(extent[axis]) / size), 1) for axis in (a, b))
    x, y = (
        np.clip((places[:, axis] - low[axis]) / size, 0, count - 1).astype(np.int64)
        for axis, count in ((a, columns), (b, rows))
    )
    cell = y * columns + x
    order = np.argsort(cell, kind="stable").astype(np.int32)
    begins = np.zeros(rows * columns + 1, np.int32)
    begins[1:] = np.cumsum(np.bincount(cell, minlength=rows * columns))
    slack = ROUNDING * (most + float(np.abs(places).max()))
    return Cells(
        np.ascontiguousarray(points[order]), order, begins, a, b, float(low[a]), float(low[b]), size, columns, rows,
        slack,
    )  # fmt: skip
