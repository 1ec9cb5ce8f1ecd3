"""Solids that have no kernels of their own: rows that hold a pose and the numbers of a shape, and their compiled type.

Their shapes are files of `strandcli.solid_shapes` or of other packages. They are the rows of one array, `others`, the
fifth field of a named tuple that is made for the kinds that a scene has (`type_of`). Kernels are compiled for that
type; scenes without such solids have `strandcli.solids.Solids` and none of this.
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
from ...scene.solid_shape import OPTIONAL, shape_of

X, Y, Z = range(3)
"""Columns of a packed solid: its origin, metres."""
ROW_X, ROW_Y, ROW_Z = 3, 6, 9
"""Where the rows of its rotation begin: world = rotation · own. Column ROW_X + k is x of its own axis k."""
REACH, KIND, NUMBERS = 12, 13, 14
"""Radius of the ball about the origin that holds it, metres; its kind's place; the first number of its shape."""

MODULE = '''\
"""Solids that have no kernels of their own, written by strandcli.solids.shapes.other for: {title}."""

from typing import Any, NamedTuple

import numpy as np

from strandcli.constants import W
from strandcli.jit import device
from strandcli.solids.kernels.distance_field import gradient, march, outward, outward_at, own, own_at, ray_in_own
from strandcli.solids.kernels.distance_field import FINE, put_outside
from strandcli.solids.kernels.segment_depth import deepest_of_all_places, deepest_of_some, put_segment_outside
{imports}

class {name}(NamedTuple):
    """`strandcli.solids.Solids` and solids of these kinds."""

    spheres: Any
    capsules: Any
    planes: Any
    boxes: Any
    others: Any

{functions}
@device
def meet(p, m, x, y, z, dx, dy, dz, end):
    """Where a ray that begins outside of solid m meets it, in units of |d|; inf where it does not up to `end`."""
    u, v, w, a, b, c = ray_in_own(p, m, x, y, z, dx, dy, dz)
{meet}

Solids = {name}
Solids.distance, Solids.normal, Solids.deepest, Solids.meet = distance, normal, deepest, meet


def collide(x, parent, grandparent, root, length, p, i, n):
    """Put particles inside of solids onto their surfaces, as `strandcli.solids.kernels.sphere.collide`."""
    for m in range(p.shape[0]):
        for k in range(W):
            x[k], x[W + k], x[2 * W + k] = put_outside(
                distance, normal, p, m, x[k], x[W + k], x[2 * W + k], np.float32(0.0)
            )


def catch(x, parent, grandparent, root, length, p, i, n):
    """Bring segments out of solids by turning them."""
    for m in range(p.shape[0]):
        for k in range(W):
            begin = parent[k], parent[W + k], parent[2 * W + k]
            x[k], x[W + k], x[2 * W + k] = put_segment_outside(
                normal, deepest, p, m, begin, x[k], x[W + k], x[2 * W + k]
            )
'''
FUNCTIONS = '''
@device
def distance{at}(p, m, x, y, z):
    """Distance of a point from the surface of solid m, {which}."""
    u, v, w = own{at}(p, m, x, y, z)
{distance}

@device
def normal{at}(p, m, x, y, z):
    """Its unit outward normal where the surface is nearest to a point."""
    u, v, w = own{at}(p, m, x, y, z)
{normal}

@device
def deepest{at}(p, m, begin, edge):
    """The share of a segment after which it is deepest in it, and the depth there."""
{deepest}
'''
"""Once for rows of an array, once for places in memory."""


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
    """(m, columns) the rows of such solids."""
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
    """The module, written for the kinds of some solids, that holds the named tuple, `distance`, `normal`, `deepest`,
    each also for places in memory (`distance_at`), `meet`, `collide` and `catch`. Raises `UsageError` for a function
    that an import statement cannot reach."""
    counts = {solid.kind: len(shape_of(solid.kind).numbers(solid)) for solid in solids}
    return _module(tuple((kind, counts[kind], shape_of(kind)) for kind in sorted(counts)))


@functools.lru_cache(maxsize=64)
def _module(kinds: tuple[tuple[str, int, Any], ...]) -> Any:
    from ... import runtime
    from ...written import module_of

    given = [(place, count, shape) for place, (_, count, shape) in enumerate(kinds)]
    imports = "".join(_imports(place, shape) for place, _, shape in given)
    functions = "".join(
        FUNCTIONS.format(
            at=at, which=which, distance=_chosen([_distance(*one, row, at) for one in given], row),
            normal=_chosen([_normal(*one, row, at) for one in given], row),
            deepest=_chosen([_deepest(shape, at) for _, _, shape in given], row),
        )
        for at, which, row in (("", "a row of p", "p[m, "), ("_at", "which begins at place m of p", "p[m + "))
    )  # fmt: skip
    meet = _chosen([_meet(*one) for one in given], "p[m, ")
    # kernels are kept by the name of the type, which therefore tells of all that it stands for
    name = f"Solids_{hashlib.sha256(''.join((imports, functions, meet)).encode()).hexdigest()[:16]}"
    title = ", ".join(kind for kind, _, _ in kinds)
    text = MODULE.format(title=title, name=name, imports=imports, functions=functions, meet=meet)
    return module_of(text, "solids", runtime.cache_folder())


def _imports(place: int, shape: Any) -> str:
    """Statements that import and compile the functions of a shape."""
    lines = []
    for part in ("distance", *OPTIONAL):
        function = getattr(shape, part, None)
        if function is None:
            continue
        where, what = function.__module__, function.__qualname__
        if where not in sys.modules or getattr(sys.modules[where], what, None) is not function:
            raise UsageError(
                f"solid {shape.kind!r}: {part} {where}.{what} must be a plain function of a module that can be imported"
            )
        digest = hashlib.sha256(inspect.getsource(sys.modules[where]).encode()).hexdigest()[:16]
        lines.append(f"from {where} import {what} as {part}_{place}  # {digest}\n")
        lines.append(f"{part}_{place} = device({part}_{place})\n")
    return "".join(lines)


def _chosen(lines: list[str], row: str) -> str:
    """Code that runs, of a line for each kind, that of a solid's kind; ``row`` begins what reads a column of it."""
    last = len(lines) - 1
    tests = [f"    if {row}{KIND}] == {place}:\n    " if place < last else "" for place in range(len(lines))]
    return "".join(f"{test}    return {line}\n" for test, line in zip(tests, lines, strict=True))


def _numbers(count: int, row: str) -> str:
    return f"({''.join(f'{row}{NUMBERS + k}], ' for k in range(count))})"


def _distance(place: int, count: int, shape: Any, row: str, at: str) -> str:
    return f"{'' if at else 'np.float32'}(distance_{place}(u, v, w, {_numbers(count, row)}))"


def _normal(place: int, count: int, shape: Any, row: str, at: str) -> str:
    if getattr(shape, "normal", None) is None:
        return f"gradient(distance{at}, p, m, FINE * {row}{REACH}], x, y, z)"
    return f"outward{at}(p, m, normal_{place}(u, v, w, {_numbers(count, row)}))"


def _deepest(shape: Any, at: str) -> str:
    way = "deepest_of_all_places" if getattr(shape, "convex", False) else "deepest_of_some"
    return f"{way}(distance{at}, p, m, begin, edge)"


def _meet(place: int, count: int, shape: Any) -> str:
    if getattr(shape, "meet", None) is None:
        return "march(distance, p, m, x, y, z, dx, dy, dz, end)"
    return f"np.float32(meet_{place}(u, v, w, a, b, c, {_numbers(count, 'p[m, ')}))"
