"""Functions of custom solids of some kinds, made of those of their shapes: in the world, for each solid its own."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...jit import device, inlined
from ...simd import lane, lane_count, pointer, with_lane
from .. import Solids
from ..custom import KIND, NUMBERS, REACH
from . import distance_field as field
from . import segment_depth
from .distance_field import in_world, look_in_world, number, outward, own, own_direction, ray_in_own, rounded

OWN_COLOUR = (np.float32(-1.0), np.float32(-1.0), np.float32(-1.0))
"""Stands for the colour of the solid."""
NONE = np.int64(-1)


class Kind(NamedTuple):
    """A kind of solids: what its shape has of `strandcli.scene.model.solids.SolidShape`."""

    name: str
    numbers: int
    """How many numbers its functions are given."""
    parts: dict[str, Any]
    """Its functions by their names."""
    data: Any
    """The class of its data, or None."""
    folds: bool
    convex: bool


def composed(module: str, name: str, kinds: Sequence[Kind]) -> tuple[Any, Any, Any]:
    """The classes of named tuples of a module: of solids of these kinds with the arrays of their shapes, of `Solids`
    and these, and of the same without built-in solids. Functions are attributes of the first."""
    fields = [
        [f"data_{place}_{field}" for field in one.data._fields] if one.data else [] for place, one in enumerate(kinds)
    ]
    every = [field for some in fields for field in some]
    named: Any = namedtuple
    custom = named(f"Custom_{name}", ["rows", *every])
    solids = named(name, [*Solids._fields, "custom", *every])
    lone: Any = type(f"Lone{name}", (solids,), {"__slots__": (), "built_in": False})
    for one in (custom, solids, lone):
        one.__module__, one.custom_class = module, custom
    custom.kinds, custom.folds = tuple(one.name for one in kinds), tuple(one.folds for one in kinds)
    custom.detailed = any(one.data for one in kinds)
    custom.among = _expression(f"lambda solids: Custom(solids.custom, {_listed('solids', every)})", Custom=custom)
    for part, function in functions_of(kinds, fields).items():
        setattr(custom, part, function)
    return custom, solids, lone


def _expression(code: str, **names: Any) -> Any:
    """What a function of as many numbers as there happen to be is for the compiler."""
    return inlined(eval(code, names))


def _listed(owner: str, fields: Sequence[str]) -> str:
    return ", ".join(f"{owner}.{field}" for field in fields)


def functions_of(kinds: Sequence[Kind], fields: Sequence[Sequence[str]]) -> dict[str, Any]:
    """Functions of solid m of some, each for the kind of solid m; None stands for what no kind, or not every, has."""
    given = [_given(one, some) for one, some in zip(kinds, fields, strict=True)]

    def of(part: str, own: Callable[..., Any], otherwise: Any, how: Any = device) -> Any:
        pairs = zip(kinds, given, strict=True)
        return chosen([own(how(one.parts[part]), these) if part in one.parts else otherwise for one, these in pairs])

    def if_all(part: str, own: Callable[..., Any], how: Any = device) -> Any:
        return of(part, own, None, how) if all(part in one.parts for one in kinds) else None

    def if_any(part: str, own: Callable[..., Any], otherwise: Any) -> Any:
        return of(part, own, otherwise) if any(part in one.parts for one in kinds) else None

    return {
        "distance_in_own": of("distance", _distance, None), "bounds": of("bounds", _bounds, _around),
        "normal": of("normal", _normal, _gradient), "meet": of("meet", _meet, field.march),
        "hides": of("hides", _hides, field.hides_by_distance), "deepest": chosen([_deepest(one) for one in kinds]),
        "distances_in_own": chosen([_distances(one, these) for one, these in zip(kinds, given, strict=True)]),
        "slopes_in_own": if_all("slopes", _in_own, inlined),
        "meets": if_all("meets", _meets), "look": if_any("look", _look, _plain),
        "drift": if_any("drift", _drift, _still),
    }  # fmt: skip


def chosen(functions: Sequence[Any]) -> Any:
    """Of functions (p, m, …), one for each kind, one that is that of solid m's kind."""
    *before, found = functions
    for place in reversed(range(len(before))):
        found = _either(place, inlined(before[place]), inlined(found))
    return found


def _either(place: int, first: Any, second: Any) -> Any:
    def either(p, m, *given):
        if number(p, m, KIND) == place:
            return first(p, m, *given)
        return second(p, m, *given)

    return either


def _given(kind: Kind, fields: Sequence[str]) -> Any:
    """A function (p, m) of what follows the coordinates in a call of a shape's function: its numbers, and its data."""
    own = "".join(f"number(p, m, {NUMBERS + k}), " for k in range(kind.numbers))
    data = f"Data({_listed('p', fields)})," if kind.data else ""
    return _expression(f"lambda p, m: (({own}), {data})", number=number, Data=kind.data)


def _distance(distance: Any, given: Any) -> Any:
    return lambda p, m, u, v, w: rounded(p, distance(u, v, w, *given(p, m)))


def _distances(kind: Kind, given: Any) -> Any:
    """Distances of vectors of points: of a shape without any, lane by lane."""
    if "distances" in kind.parts:
        return _in_own(inlined(kind.parts["distances"]), given)
    one = device(_distance(device(kind.parts["distance"]), given))

    def found(p, m, u, v, w):
        for k in range(lane_count(pointer(p.rows))):
            u = with_lane(u, k, one(p, m, lane(u, k), lane(v, k), lane(w, k)))
        return u

    return found


def _in_own(function: Any, given: Any) -> Any:
    return lambda p, m, u, v, w: function(u, v, w, *given(p, m))


def _bounds(bounds: Any, given: Any) -> Any:
    return lambda p, m: bounds(*given(p, m))


def _around(p, m):
    around = number(p, m, REACH)
    return -around, -around, -around, around, around, around


def _normal(normal: Any, given: Any) -> Any:
    def found(p, m, x, y, z):
        u, v, w = own(p, m, x, y, z)
        return outward(p, m, normal(u, v, w, *given(p, m)))

    return found


def _gradient(p, m, x, y, z):
    return field.gradient(p, m, field.FINE * number(p, m, REACH), x, y, z)


def _meet(meet: Any, given: Any) -> Any:
    def found(p, m, x, y, z, dx, dy, dz, end):
        u, v, w, a, b, c = ray_in_own(p, m, x, y, z, dx, dy, dz)
        return np.float32(meet(u, v, w, a, b, c, *given(p, m)))

    return found


def _meets(meets: Any, given: Any) -> Any:
    return lambda p, m, rays, found: meets(rays, found, *given(p, m))


def _hides(hides: Any, given: Any) -> Any:
    def found(p, m, x, y, z, direction, reach, skin):
        u, v, w, a, b, c = ray_in_own(p, m, x, y, z, direction[0], direction[1], direction[2])
        return hides(u, v, w, a, b, c, reach, skin, *given(p, m))

    return found


def _look(look: Any, given: Any) -> Any:
    def found(p, m, x, y, z, eye, width, before):
        u, v, w = own(p, m, x, y, z)
        eye = own_direction(p, m, eye[0], eye[1], eye[2])
        return look_in_world(p, m, look(u, v, w, eye, width, before, *given(p, m)))

    return found


def _plain(p, m, x, y, z, eye, width, before):
    return field.normal(p, m, x, y, z), (x, y, z), OWN_COLOUR, NONE


def _drift(drift: Any, given: Any) -> Any:
    def found(p, m, x, y, z):
        u, v, w = own(p, m, x, y, z)
        return in_world(p, m, drift(u, v, w, *given(p, m)))

    return found


def _still(p, m, x, y, z):
    return 0.0, 0.0, 0.0


def _deepest(kind: Kind) -> Any:
    if kind.convex:
        return segment_depth.deepest_of_all_places
    return segment_depth.deepest_about_some if kind.data else segment_depth.deepest_of_some
