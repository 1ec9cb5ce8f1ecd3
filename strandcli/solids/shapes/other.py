"""Solids of other packages: rows that hold a pose and the numbers of a signed distance, and their compiled type.

All of them are the rows of one array, `others`, the fifth field of a named tuple that is made for the kinds that a
scene has (`type_of`). Kernels are compiled for that type; scenes without such solids have `strandcli.solids.Solids` and
none of this.
"""

from __future__ import annotations

import functools
import hashlib
import inspect
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import UsageError
from ...scene.motion import Pose
from ...scene.solid_shape import shape_of

X, Y, Z = range(3)
"""Columns of a packed solid: its origin, metres."""
ROW_X, ROW_Y, ROW_Z = 3, 6, 9
"""Where the rows of its rotation begin: world = rotation · own. Column ROW_X + k is x of its own axis k."""
REACH, KIND, NUMBERS = 12, 13, 14
"""Radius of the ball about the origin that holds it, metres; its kind's place; the first number of its shape."""

TEMPLATE = '''\
"""Solids of other packages, written by strandcli.solids.shapes.other for: {title}."""

from typing import Any, NamedTuple

import numpy as np

from strandcli.constants import W
from strandcli.jit import device
from strandcli.solids.kernels.distance_field import own, own_at, put_outside, put_segment_outside
{imports}

class {name}(NamedTuple):
    """`strandcli.solids.Solids` and solids of these kinds."""

    spheres: Any
    capsules: Any
    planes: Any
    boxes: Any
    others: Any


@device
def distance(p, m, x, y, z):
    """Distance of a point from the surface of solid m, a row of p."""
    u, v, w = own(p, m, x, y, z)
{rows}

@device
def distance_at(p, m, x, y, z):
    """The same of the solid that begins at place m of p."""
    u, v, w = own_at(p, m, x, y, z)
{places}

{name}.distance = distance
Solids = {name}


def collide(x, parent, grandparent, root, length, p, i, n):
    """Put particles inside of solids onto their surfaces, as `strandcli.solids.kernels.sphere.collide`."""
    for m in range(p.shape[0]):
        for k in range(W):
            x[k], x[W + k], x[2 * W + k] = put_outside(distance, p, m, x[k], x[W + k], x[2 * W + k], np.float32(0.0))


def catch(x, parent, grandparent, root, length, p, i, n):
    """Bring segments out of solids by moving their far ends."""
    for m in range(p.shape[0]):
        for k in range(W):
            begin = parent[k], parent[W + k], parent[2 * W + k]
            x[k], x[W + k], x[2 * W + k] = put_segment_outside(distance, p, m, begin, x[k], x[W + k], x[2 * W + k])
'''


def kinds_of(solids: Sequence[Any]) -> tuple[str, ...]:
    """The kinds of some solids, each once."""
    return tuple(sorted({solid.kind for solid in solids}))


def columns_of(solids: Sequence[Any]) -> int:
    """Columns of the array of some solids."""
    return NUMBERS + max(len(shape_of(one.kind).numbers(one)) for one in solids)


def numbers(solid: Any, pose: Pose, kinds: tuple[str, ...]) -> list[float]:
    """The row of a solid that has a pose, among those of some kinds."""
    a, b, c = pose.rotation
    shape = shape_of(solid.kind)
    own = [float(one) for one in shape.numbers(solid)]
    return [*pose.translation, *a, *b, *c, float(shape.reach(solid)), float(kinds.index(solid.kind)), *own]


def pack(solids: Sequence[Any], poses: Sequence[Pose], dtype: Any) -> NDArray[Any]:
    """(m, columns) the rows of solids of other packages."""
    kinds = kinds_of(solids)
    out = np.zeros((len(solids), columns_of(solids)), dtype)
    for row, solid, pose in zip(out, solids, poses, strict=True):
        found = numbers(solid, pose, kinds)
        row[: len(found)] = found
    return out


def ball(row: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Centre and radius of a ball about a packed solid."""
    return row[:3], float(row[REACH])


def depth(solid: Any, row: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(k,) depth of points (k, 3) below the surface of a packed solid, metres; not positive outside."""
    distance: Any = shape_of(solid.kind).distance
    own = (points - row[:3]) @ row[ROW_X:REACH].reshape(3, 3)
    given = tuple(row[NUMBERS:].tolist())
    outside = np.linalg.norm(own, axis=1) - row[REACH]
    found = zip(outside.tolist(), own.tolist(), strict=True)
    return np.array([-far if far > 0 else -float(distance(*one, given)) for far, one in found])


def type_of(solids: Sequence[Any]) -> Any:
    """The named tuple's type for the kinds of some solids."""
    return module_for(solids).Solids


def module_for(solids: Sequence[Any]) -> Any:
    """The module, written for the kinds of some solids, that holds the named tuple, `distance`, `distance_at`,
    `collide` and `catch`. Raises `UsageError` for a distance that an import statement cannot reach."""
    counts = {solid.kind: len(shape_of(solid.kind).numbers(solid)) for solid in solids}
    return _module(tuple((kind, counts[kind], shape_of(kind)) for kind in sorted(counts)))


@functools.lru_cache(maxsize=64)
def _module(kinds: tuple[tuple[str, int, Any], ...]) -> Any:
    from ... import runtime
    from ...written import module_of

    imports: list[str] = []
    rows: list[str] = []
    places: list[str] = []
    for place, (kind, count, shape) in enumerate(kinds):
        function = shape.distance
        where, what = function.__module__, function.__qualname__
        if where not in sys.modules or getattr(sys.modules[where], what, None) is not function:
            raise UsageError(
                f"solid {kind!r}: distance {where}.{what} must be a plain function of a module that can be imported"
            )
        digest = hashlib.sha256(inspect.getsource(sys.modules[where]).encode()).hexdigest()[:16]
        imports.append(f"from {where} import {what} as function_{place}  # {digest}\n")
        imports.append(f"shape_{place} = device(function_{place})\n")
        for lines, begin, cast in ((rows, "p[m, ", "np.float32"), (places, "p[m + ", "")):
            given = "".join(f"{begin}{NUMBERS + k}], " for k in range(count))
            test = f"    if {begin}{KIND}] == {place}:\n    " if place < len(kinds) - 1 else ""
            lines.append(f"{test}    return {cast}(shape_{place}(u, v, w, ({given})))\n")
    # kernels are kept by the name of the type, which therefore tells of all that it stands for
    name = f"Solids_{hashlib.sha256(''.join([*imports, *rows]).encode()).hexdigest()[:16]}"
    text = TEMPLATE.format(
        title=", ".join(kind for kind, _, _ in kinds), name=name, imports="".join(imports), rows="".join(rows),
        places="".join(places),
    )  # fmt: skip
    return module_of(text, "solids", runtime.cache_folder())
