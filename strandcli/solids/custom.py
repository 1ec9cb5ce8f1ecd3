"""Custom solids, whose shapes are files of `strandcli.solid_shapes` or of other packages: their rows and their data.

They are the rows of one array, the fifth field of a named tuple whose class is made for the kinds that a scene has,
after which come the arrays of shapes that have `data`. The class has the functions of these kinds (`kernels.compose`),
and kernels are compiled for it; scenes without such solids have `strandcli.solids.Solids` and none of this.
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

from ..errors import UsageError
from ..scene.model.solids import OPTIONAL, has_data, shape_of
from ..scene.motion import Pose

X, Y, Z = range(3)
"""Columns of a packed solid: its origin, metres."""
ROW_X, ROW_Y, ROW_Z = 3, 6, 9
"""Where the rows of its rotation begin: world = rotation · own. Column ROW_X + k is x of its own axis k."""
REACH, KIND, NUMBERS = 12, 13, 14
"""Radius of the ball about the origin that holds it, metres; its kind's place; the first number of its shape."""
TEXT = '''\
"""Custom solids, written by strandcli.solids.custom for: {title}."""

from strandcli.solids.kernels.compose import Kind, composed
{imports}
Custom_{name}, {name}, Lone{name} = Custom, Solids, LoneSolids = composed(__name__, "{name}", [
{kinds}])
'''
"""A module that kernels of these solids are made of: their names in the cache follow from it, and it is imported with
them."""


def kinds_of(solids: Sequence[Any]) -> tuple[str, ...]:
    """The kinds of some solids, each once."""
    return tuple(sorted({solid.kind for solid in solids}))


def of_kind(kind: str, solids: Sequence[Any]) -> list[Any]:
    """Those of solids that are of a kind, in order."""
    return [one for one in solids if one.kind == kind]


def count_of(solid: Any) -> int:
    """How many numbers the functions of a solid's shape are given: those of the shape, and where it has data, the
    solid's place among those that share it."""
    shape = shape_of(solid.kind)
    return len(shape.numbers(solid)) + has_data(shape)


def columns_of(solids: Sequence[Any]) -> int:
    """Columns of the array of some solids."""
    return NUMBERS + max(count_of(one) for one in solids)


def numbers(solid: Any, pose: Pose, among: Sequence[Any]) -> list[float]:
    """The row of a solid that has a pose, one of the solids ``among``."""
    a, b, c = pose.rotation
    shape = shape_of(solid.kind)
    own = [float(one) for one in shape.numbers(solid)]
    if has_data(shape):
        own.append(float(next(place for place, one in enumerate(of_kind(solid.kind, among)) if one is solid)))
    kind = kinds_of(among).index(solid.kind)
    return [*pose.translation, *a, *b, *c, float(shape.reach(solid)), float(kind), *own]


def pack(solids: Sequence[Any], poses: Sequence[Pose], dtype: Any) -> NDArray[Any]:
    """(m, columns) the rows of such solids."""
    out = np.zeros((len(solids), columns_of(solids)), dtype)
    for row, solid, pose in zip(out, solids, poses, strict=True):
        found = numbers(solid, pose, solids)
        row[: len(found)] = found
    return out


def data_of(solids: Sequence[Any], time: float, past: float | None = None) -> list[NDArray[Any]]:
    """The arrays of the shapes of some solids at a time in seconds, kind after kind; ``past``: that of the step before,
    for shapes that carry along what touches them."""
    found: list[NDArray[Any]] = []
    for kind in kinds_of(solids):
        shape: Any = shape_of(kind)
        if has_data(shape):
            more = () if past is None or getattr(shape, "drift", None) is None else (past,)
            found += shape.data(of_kind(kind, solids), time, *more)
    return found


def ball(row: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Centre and radius of a ball about a packed solid."""
    return row[:3], float(row[REACH])


def together(solids: Sequence[Any], rows: NDArray[Any], time: float) -> Any:
    """Packed solids and the data of their shapes, as kernels take them by themselves."""
    return module_for(solids).Custom(rows, *data_of(solids, time))


def module_for(solids: Sequence[Any]) -> Any:
    """The module of the kinds of some solids, with the classes of named tuples `Custom`, of their rows and data alone,
    `Solids` and `LoneSolids`, where there are no solids but these. Raises `UsageError` for a function that an import
    statement cannot reach."""
    first = {solid.kind: solid for solid in solids}
    return _module(tuple((shape_of(kind), count_of(first[kind])) for kind in kinds_of(solids)))


@functools.lru_cache(maxsize=64)
def _module(kinds: tuple[tuple[Any, int], ...]) -> Any:
    from ..compiling import runtime
    from ..compiling.folder import module_of

    imports, rows = "", ""
    for place, (shape, count) in enumerate(kinds):
        parts = [part for part in ("distance", *OPTIONAL) if getattr(shape, part, None) is not None]
        for part in (*parts, "Data") if has_data(shape) else parts:
            imports += _import(shape, part, place)
        functions = ", ".join(f'"{part}": {part}_{place}' for part in parts)
        data = f"Data_{place}" if has_data(shape) else None
        flags = ", ".join(str(bool(getattr(shape, flag, False))) for flag in ("folds", "convex"))
        rows += f'    Kind("{shape.kind}", {count}, {{{functions}}}, {data}, {flags}),\n'
    # two classes of one name would have kernels of one name
    name = f"Solids_{hashlib.sha256((imports + rows).encode()).hexdigest()[:16]}"
    title = ", ".join(shape.kind for shape, _ in kinds)
    return module_of(TEXT.format(title=title, imports=imports, name=name, kinds=rows), "solids", runtime.cache_folder())


def _import(shape: Any, part: str, place: int) -> str:
    """The statement that imports a part of a shape, with the hash of the text that it stands in."""
    thing = getattr(shape, part)
    where, what = thing.__module__, thing.__qualname__
    if where not in sys.modules or getattr(sys.modules[where], what, None) is not thing:
        raise UsageError(
            f"solid {shape.kind!r}: {part} {where}.{what} must be a plain function of a module that can be imported"
        )
    digest = hashlib.sha256(inspect.getsource(sys.modules[where]).encode()).hexdigest()[:16]
    return f"from {where} import {what} as {part}_{place}  # {digest}\n"
