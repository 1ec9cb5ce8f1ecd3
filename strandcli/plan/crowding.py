"""How many pairs of segments the rule contact looks at in a step, and in how many cells it looks for them.

Counted for a sample of the strands as they are emitted and turned out of solids, since pairs grow with the square of
strands and with how dense they stand.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, NamedTuple

from ..files.inputs import cached
from ..scene.touched import touched

if TYPE_CHECKING:
    from ..groom.record import Groom
    from ..scene.model import Emitter, Rod, Scene

    Numbers = Any  # arrays of float64; numpy is not imported for a scene without contact

GUESS, GUESSED_CELLS, FINEST = 3.0, 8.0, 2000
"""Pairs and cells of a particle of strands from a file, which is not read for it, or of strands of more particles."""
STRANDS, PARTICLES, SAMPLE = 5000, 100_000, 256
"""Strands that are emitted for it at the most, and particles, and segments whose neighbours are counted."""
ROUNDS, SLOPE = 3, 1e-4
"""Times that a particle is put out of the solid that it is deepest in, and the share of a segment over which the slope
of depth is taken."""
GRAVITY = 9.81
"""m/s². Boxes hold a segment's way in a step, which at the start is that of a fall."""
FAR = 1e6
"""Metres; boxes need not be larger to meet."""


class Crowding(NamedTuple):
    """What contact looks at in a step."""

    pairs: float
    """Pairs of segments whose boxes meet."""
    cells: float
    """Cells that segments lie in, each counted by itself."""


def crowding_of(scene: Scene, strands: int) -> Crowding:
    """Return what contact looks at among so many strands; zeros without the rule."""
    thickness = next((use.parameters.thickness for use in scene.rules if use.name == "contact"), 0.0)
    if thickness == 0.0 or scene.solver != "rod" or strands < 2:
        return Crowding(0.0, 0.0)
    import numpy as np

    emitter = scene.emitter
    if emitter.groom is not None or emitter.particles > FINEST:
        return Crowding(GUESS * strands * emitter.particles, GUESSED_CELLS * strands * emitter.particles)
    few = dataclasses.replace(emitter, strands=min(strands, STRANDS, PARTICLES // emitter.particles))
    fall = min(GRAVITY / (scene.time.fps * scene.time.substeps) ** 2, FAR)
    with np.errstate(all="ignore"):  # of numbers that nobody means
        counted = _counted(few, scene.seed, thickness, scene.rod, fall, tuple(touched(scene)))
    times = strands / few.strands
    return Crowding(counted.pairs * times**2, counted.cells * times)


@cached(4)
def _counted(
    emitter: Emitter, seed: int, thickness: float | None, rod: Rod, fall: float, solids: tuple[Any, ...]
) -> Crowding:
    """The same of the strands that are emitted."""
    import numpy as np

    from ..groom.emit import emit
    from ..simulate.contact.nearby import cell_side
    from ..simulate.rod.material import MARGIN, matter

    groom = emit(emitter, seed)
    reach = min((1 + MARGIN) * (thickness or 2 * matter(rod)[1]), FAR)
    strands, held = _turned_out(groom, emitter, solids)
    low, high = [], []
    for axis in range(3):
        x = strands[:, :, axis]
        under = x - np.where(held, 0, fall) if axis == 1 else x
        low.append((np.minimum(under[:, :-1], under[:, 1:]) - reach / 2).ravel())
        high.append((np.maximum(x[:, :-1], x[:, 1:]) + reach / 2).ravel())
    total, each = len(low[0]), emitter.particles - 1
    some: Any = np.linspace(0, total - 1, min(SAMPLE, total)).astype(np.int64)
    found = 0
    for place in some:
        meets = np.ones(total, np.bool_)
        for least, most in zip(low, high, strict=True):
            meets &= (least <= most[place]) & (most >= least[place])
        own = place // each * each
        meets[own : own + each] = False
        found += int(np.count_nonzero(meets))
    least, most = np.stack(low, axis=1), np.stack(high, axis=1)
    cells = (np.floor(most / (side := cell_side(least, most))) - np.floor(least / side) + 1).prod(1).mean()
    return Crowding(0.5 * found / len(some) * total, total * float(np.nan_to_num(cells, nan=1.0)))


def _turned_out(groom: Groom, emitter: Emitter, solids: tuple[Any, ...]) -> tuple[Numbers, Numbers]:
    """Return (S, N, 3) the particles of straight strands in the world at time 0, metres, each edge of which keeps its
    length and is turned until its end is outside of solids, those alone that `SHAPES` has, as before the first step;
    and (S, N) which do not fall: roots, and those that a solid holds."""
    import numpy as np

    from ..scene.motion import emitter_pose
    from ..solids import SHAPES, pack

    pose = emitter_pose(emitter, 0.0)
    turn = np.array(pose.rotation)
    rows = {kind: pack(kind, list(solids), emitter, 0.0, np.float64) for kind in SHAPES}
    shapes = [(SHAPES[kind].depth, row) for kind, mine in rows.items() for row in mine]
    way = groom.directions.astype(np.float64) @ turn.T
    length = groom.lengths.astype(np.float64)[:, None] / (emitter.particles - 1)
    x = np.empty((len(way), emitter.particles, 3))
    held = np.zeros(x.shape[:2], np.bool_)
    held[:, 0] = True
    x[:, 0] = groom.roots.astype(np.float64) @ turn.T + pose.translation
    for j in range(1, emitter.particles):
        edge = _edge_out(shapes, x[:, j - 1], way, length) if shapes else way
        x[:, j], held[:, j] = x[:, j - 1] + length * edge, (edge != way).any(1)
    return x, held


def _edge_out(shapes: list[Any], start: Numbers, way: Numbers, length: Numbers) -> Numbers:
    """Return unit vectors near ``way`` (S, 3), along which edges from ``start`` end outside of solids, or as far out as
    they can."""
    import numpy as np

    way = way.copy()
    for _ in range(ROUNDS):
        end = start + length * way
        deepest = np.argmax([depth(row, end) for depth, row in shapes], axis=0)
        for number, (depth, row) in enumerate(shapes):
            inside = np.flatnonzero((deepest == number) & (depth(row, end) > 0))
            if len(inside):
                at, step = end[inside], SLOPE * length[inside]
                here = depth(row, at)
                out = np.stack([here - depth(row, at + step * axis) for axis in np.eye(3)], axis=1)
                out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-30)
                edge = at + here[:, None] * out - start[inside]
                way[inside] = edge / np.maximum(np.linalg.norm(edge, axis=1, keepdims=True), 1e-30)
    return way
