"""Code of solids that have no kernels of their own: a module written for the kinds that a scene has."""

from __future__ import annotations

import functools
import hashlib
import inspect
import sys
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import UsageError
from ...scene.solid_shape import OPTIONAL, has_data, shape_of
from .other import KIND, NUMBERS, REACH, ROW_X, count_of, data_of, kinds_of
from .other_template import DISTANCES, DRIFT, LOOK, MEETS, MODULE, RAY, SLOPES


class Kind(NamedTuple):
    """A kind of solid among those that a module is written for."""

    place: int
    numbers: int
    """How many numbers its functions are given."""
    shape: Any


def type_of(solids: Sequence[Any], others: Sequence[Any]) -> Any:
    """The named tuple's type for solids, of which ``others`` have no kernels of their own."""
    module = module_for(others)
    return module.Solids if len(solids) > len(others) else module.LoneSolids


def together(solids: Sequence[Any], rows: NDArray[Any], time: float) -> Any:
    """Packed solids and the data of their shapes, as kernels take them by themselves."""
    return module_for(solids).Others(rows, *data_of(solids, time))


def depth(solid: Any, row: NDArray[np.float64], points: NDArray[np.float64], time: float = 0.0) -> NDArray[np.float64]:
    """(k,) depth of points (k, 3) below the surface of a packed solid at a time, metres; not positive outside."""
    shape: Any = shape_of(solid.kind)
    own = (points - row[:3]) @ row[ROW_X:REACH].reshape(3, 3)
    outside = np.linalg.norm(own, axis=1) - row[REACH]
    if has_data(shape):
        found = outside.copy()
        near = np.flatnonzero(outside <= 0)
        away = np.zeros(len(near))
        module_for([solid]).distances(together([solid], row[None], time), 0, np.ascontiguousarray(points[near]), away)
        found[near] = away
        return -found
    given = tuple(row[NUMBERS:].tolist())
    pairs = zip(outside.tolist(), own.tolist(), strict=True)
    return np.array([-far if far > 0 else -float(shape.distance(*one, given)) for far, one in pairs])


def module_for(solids: Sequence[Any]) -> Any:
    """The module, written for the kinds of some solids, that holds the named tuple, `Others`, `distance`, `normal`,
    `deepest`, `meet`, `collide`, `catch` and `drift`, which is None where no kind has one. Raises `UsageError` for a
    function that an import statement cannot reach."""
    first = {solid.kind: solid for solid in solids}
    kinds = kinds_of(solids)
    return _module(tuple(Kind(place, count_of(first[kind]), shape_of(kind)) for place, kind in enumerate(kinds)))


@functools.lru_cache(maxsize=64)
def _module(kinds: tuple[Kind, ...]) -> Any:
    from ...compiling import runtime
    from ...compiling.written import module_of

    imports = "".join(_imports(one) for one in kinds)
    data = fields_of(kinds)
    parts = {
        "distance": _chosen([f"rounded(p, distance_{one.place}(u, v, w, {_given(one)}))" for one in kinds]),
        "normal": _chosen([_normal(one) for one in kinds]),
        "deepest": _chosen([_deepest(one.shape) for one in kinds]),
        "meet": _chosen([_meet(one) for one in kinds]),
        "hides": _chosen([_hides(one) for one in kinds]),
        "ray": RAY if _any(kinds, "hides") else "",
        "look": LOOK.format(look=_chosen([_look(one) for one in kinds])) if _looks(kinds) else "\n",
        "fields": "".join(f"    {one}: Any\n" for one in data),
        "given": ", ".join(f"solids.{one}" for one in ("others", *data)),
        "drift": DRIFT.format(drift=_chosen([_drift(one) for one in kinds])) if _any(kinds, "drift") else "",
        "has_drift": "drift_of" if _any(kinds, "drift") else "None",
        "has_look": "look" if _looks(kinds) else "None",
        "distances": _distances(kinds) + _slopes(kinds),
        "bounds": _chosen([_bounds(one) for one in kinds]),
        "meets": _meets(kinds),
        "has_meets": "meets" if _meets(kinds).strip() else "None",
        "reach": REACH,
        "has_distances": "distances_in_own" if _distances(kinds).strip() else "None",
        "has_slopes": "slopes_in_own" if _slopes(kinds) else "None",
        "detailed": any(has_data(one.shape) for one in kinds),
        "folds": tuple(bool(getattr(one.shape, "folds", False)) for one in kinds),
    }
    # kernels are kept by the name of the type, which therefore tells of all that it stands for
    name = f"Solids_{hashlib.sha256((imports + str(parts)).encode()).hexdigest()[:16]}"
    names = tuple(one.shape.kind for one in kinds)
    title = ", ".join(names)
    return module_of(
        MODULE.format(title=title, kinds=names, name=name, imports=imports, **parts), "solids", runtime.cache_folder()
    )


def fields_of(kinds: Sequence[Kind]) -> list[str]:
    """Names of the fields that hold the arrays of the kinds' data."""
    return [f"data_{one.place}_{field}" for one in kinds if has_data(one.shape) for field in one.shape.Data._fields]


def _distances(kinds: Sequence[Kind]) -> str:
    """Code of the distances of vectors; nothing where a kind lacks them."""
    if not all(_has(one.shape, "distances") for one in kinds):
        return "\n"
    return DISTANCES.format(distances=_chosen([f"distances_{one.place}(u, v, w, {_given(one)})" for one in kinds]))


def _slopes(kinds: Sequence[Kind]) -> str:
    """Code of the distances of vectors with their gradients; nothing where a kind lacks them."""
    if not all(_has(one.shape, "slopes") for one in kinds):
        return ""
    return SLOPES.format(slopes=_chosen([f"slopes_{one.place}(u, v, w, {_given(one)})" for one in kinds]))


def _meets(kinds: Sequence[Kind]) -> str:
    """Code of rays that go together; nothing where a kind lacks it."""
    if not all(_has(one.shape, "meets") for one in kinds):
        return "\n"
    return MEETS.format(meets=_chosen([f"meets_{one.place}(rays, found, {_given(one)})" for one in kinds]))


def _any(kinds: Sequence[Kind], part: str) -> bool:
    return any(_has(one.shape, part) for one in kinds)


def _looks(kinds: Sequence[Kind]) -> bool:
    return _any(kinds, "look") or _any(kinds, "look_after")


def _has(shape: Any, part: str) -> bool:
    return getattr(shape, part, None) is not None


def _imports(kind: Kind) -> str:
    """Statements that import and compile the functions of a shape."""
    lines = []
    shape, place = kind.shape, kind.place
    for part in ("distance", *OPTIONAL):
        function = getattr(shape, part, None)
        if function is None:
            continue
        lines.append(_import(shape, part, function, place))
        way = "inlined" if part in ("distances", "slopes") else "device"  # vectors, which calls would write to memory
        lines.append(f"{part}_{place} = {way}({part}_{place})\n")
    if has_data(shape):
        lines.append(_import(shape, "Data", shape.Data, place))
    return "".join(lines)


def _import(shape: Any, part: str, thing: Any, place: int) -> str:
    where, what = thing.__module__, thing.__qualname__
    if where not in sys.modules or getattr(sys.modules[where], what, None) is not thing:
        raise UsageError(
            f"solid {shape.kind!r}: {part} {where}.{what} must be a plain function of a module that can be imported"
        )
    digest = hashlib.sha256(inspect.getsource(sys.modules[where]).encode()).hexdigest()[:16]
    return f"from {where} import {what} as {part}_{place}  # {digest}\n"


def _chosen(lines: list[str]) -> str:
    """Code that runs, of a line for each kind, that of a solid's kind."""
    last = len(lines) - 1
    tests = [f"    if number(p, m, {KIND}) == {place}:\n    " if place < last else "" for place in range(len(lines))]
    return "".join(f"{test}    return {line}\n" for test, line in zip(tests, lines, strict=True))


def _given(kind: Kind) -> str:
    """What follows the coordinates in a call of a shape's function: its numbers and perhaps its data."""
    numbers = "".join(f"number(p, m, {NUMBERS + k}), " for k in range(kind.numbers))
    if not has_data(kind.shape):
        return f"({numbers})"
    arrays = ", ".join(f"p.{field}" for field in fields_of([kind]))
    return f"({numbers}), Data_{kind.place}({arrays})"


def _bounds(kind: Kind) -> str:
    if not _has(kind.shape, "bounds"):
        return "-around, -around, -around, around, around, around"
    return f"bounds_{kind.place}({_given(kind)})"


def _normal(kind: Kind) -> str:
    if not _has(kind.shape, "normal"):
        return f"gradient(distance, p, m, FINE * number(p, m, {REACH}), x, y, z)"
    return f"outward(p, m, normal_{kind.place}(u, v, w, {_given(kind)}))"


def _deepest(shape: Any) -> str:
    way = "deepest_about_some" if has_data(shape) else "deepest_of_some"
    way = "deepest_of_all_places" if getattr(shape, "convex", False) else way
    return f"{way}(distance, p, m, begin, edge)"


def _meet(kind: Kind) -> str:
    if not _has(kind.shape, "meet"):
        return "march(distance, p, m, x, y, z, dx, dy, dz, end)"
    return f"np.float32(meet_{kind.place}(u, v, w, a, b, c, {_given(kind)}))"


def _hides(kind: Kind) -> str:
    if not _has(kind.shape, "hides"):
        return "hides_by_distance(distance, meet, p, m, x, y, z, way, reach, skin)"
    return f"hides_{kind.place}(u, v, w, a, b, c, reach, skin, {_given(kind)})"


def _look(kind: Kind) -> str:
    if _has(kind.shape, "look_after"):
        return f"looks_in_world(p, m, look_after_{kind.place}(u, v, w, eye, width, before, {_given(kind)}))"
    if not _has(kind.shape, "look"):
        return "normal(p, m, x, y, z), (x, y, z), (np.float32(-1.0), np.float32(-1.0), np.float32(-1.0)), np.int64(-1)"
    return f"look_in_world(p, m, look_{kind.place}(u, v, w, eye, width, {_given(kind)})) + (np.int64(-1),)"


def _drift(kind: Kind) -> str:
    if not _has(kind.shape, "drift"):
        return "0.0, 0.0, 0.0"
    return f"in_world(p, m, drift_{kind.place}(u, v, w, {_given(kind)}))"
