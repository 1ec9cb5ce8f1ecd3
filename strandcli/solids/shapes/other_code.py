"""Code of solids that have no kernels of their own: a module written for the kinds that a scene has."""

from __future__ import annotations

import functools
import hashlib
import inspect
import sys
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import UsageError
from ...scene.model.solids import OPTIONAL, has_data, shape_of
from .other import KIND, NUMBERS, REACH, ROW_X, count_of, data_of, kinds_of
from .other_template import DISTANCES, DRIFT, LOOK, MEETS, MODULE, RAY, SLOPES

GRADIENT = "gradient(distance, p, m, FINE * number(p, m, {reach}), x, y, z)"
MARCH = "march(distance, p, m, x, y, z, dx, dy, dz, end)"
HIDES = "hides_by_distance(distance, meet, p, m, x, y, z, way, reach, skin)"
LOOKS = "look_in_world(p, m, look_{place}(u, v, w, eye, width, before, {given}))"
PLAIN = "normal(p, m, x, y, z), (x, y, z), (np.float32(-1.0), np.float32(-1.0), np.float32(-1.0)), np.int64(-1)"


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
    from ...compiling.folder import module_of

    imports = "".join(_imports(one) for one in kinds)
    data = fields_of(kinds)
    vectors = _code(kinds, "distances", DISTANCES, all, "distances_{place}(u, v, w, {given})")
    slopes = _code(kinds, "slopes", SLOPES, all, "slopes_{place}(u, v, w, {given})")
    meets = _code(kinds, "meets", MEETS, all, "meets_{place}(rays, found, {given})")
    look = _code(kinds, "look", LOOK, any, LOOKS, PLAIN)
    drift = _code(kinds, "drift", DRIFT, any, "in_world(p, m, drift_{place}(u, v, w, {given}))", "0.0, 0.0, 0.0")
    parts = {
        "distance": _chosen(kinds, "distance", "rounded(p, distance_{place}(u, v, w, {given}))"),
        "normal": _chosen(kinds, "normal", "outward(p, m, normal_{place}(u, v, w, {given}))", GRADIENT),
        "deepest": _chosen(kinds, "convex", "deepest_of_all_places(distance, p, m, begin, edge)", "{deepest}"),
        "meet": _chosen(kinds, "meet", "np.float32(meet_{place}(u, v, w, a, b, c, {given}))", MARCH),
        "hides": _chosen(kinds, "hides", "hides_{place}(u, v, w, a, b, c, reach, skin, {given})", HIDES),
        "bounds": _chosen(
            kinds, "bounds", "bounds_{place}({given})", "-around, -around, -around, around, around, around"
        ),
        "ray": RAY if any(_has(one.shape, "hides") for one in kinds) else "",
        "fields": "".join(f"    {one}: Any\n" for one in data),
        "given": ", ".join(f"solids.{one}" for one in ("others", *data)),
        "look": look or "\n",
        "drift": drift,
        "distances": vectors + slopes,
        "meets": meets,
        "has_drift": "drift_of" if drift else "None",
        "has_look": "look" if look else "None",
        "has_meets": "meets" if meets else "None",
        "has_distances": "distances_in_own" if vectors else "None",
        "has_slopes": "slopes_in_own" if slopes else "None",
        "detailed": any(has_data(one.shape) for one in kinds),
        "folds": tuple(bool(getattr(one.shape, "folds", False)) for one in kinds),
        "reach": REACH,
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


def _has(shape: Any, part: str) -> bool:
    return bool(getattr(shape, part, None))


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


def _chosen(kinds: Sequence[Kind], part: str, own: str, otherwise: str = "") -> str:
    """Code that runs, of a line for each kind, that of a solid's kind: its ``own`` where the shape has a part."""
    lines = [
        (own if _has(one.shape, part) else otherwise).format(
            place=one.place, given=_given(one), reach=REACH,
            deepest=f"deepest_{'about' if has_data(one.shape) else 'of'}_some(distance, p, m, begin, edge)",
        ) for one in kinds
    ]  # fmt: skip
    last = len(lines) - 1
    tests = [f"    if number(p, m, {KIND}) == {place}:\n    " if place < last else "" for place in range(len(lines))]
    return "".join(f"{test}    return {line}\n" for test, line in zip(tests, lines, strict=True))


def _code(
    kinds: Sequence[Kind], part: str, template: str, enough: Callable[..., bool], own: str, otherwise: str = ""
) -> str:  # fmt: skip
    """The function of a part, if ``enough`` of the kinds have it: all or any; else nothing."""
    if not enough(_has(one.shape, part) for one in kinds):
        return ""
    return template.format(code=_chosen(kinds, part, own, otherwise))


def _given(kind: Kind) -> str:
    """What follows the coordinates in a call of a shape's function: its numbers and perhaps its data."""
    numbers = "".join(f"number(p, m, {NUMBERS + k}), " for k in range(kind.numbers))
    if not has_data(kind.shape):
        return f"({numbers})"
    arrays = ", ".join(f"p.{field}" for field in fields_of([kind]))
    return f"({numbers}), Data_{kind.place}({arrays})"
