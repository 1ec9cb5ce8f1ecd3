"""Strands as the worker is to write them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ...errors import UsageError
from ...output.files import placed
from ..objects import Pieces, pieces, renamed
from ..strands import Attribute, Domain, Layer, Points, Strands, TimeSample
from ..written import box_of, checked, left_out
from .process import Message, ask

NAMES = {
    "widths": "width", "normals": "normal", "displayColor": "colour", "displayOpacity": "transparency", "st": "uv",
    "groom_root_uv": "root_uv", "groom_color": "colour", "groom_width": "width",
}  # fmt: skip
"""Names of attributes: USD's own, those of Unreal's grooms, and ours."""
INTERPOLATION: dict[Domain, str] = {"groom": "constant", "strand": "uniform", "point": "vertex"}
THEIRS = {ours: theirs for theirs, ours in reversed(NAMES.items())}
"""USD's names of attributes."""
EXTENTS = {"width": 1, "colour": 3, "transparency": 1, "normal": 3, "uv": 2, "root_uv": 2}
"""Numbers that these have a row; they are floating-point."""
KINDS = {"B": "B", "i": "i", "q": "q", "l": "q"}
"""Integers that USD has, by those of numpy."""
Attributes = list[tuple[str, str, npt.NDArray[Any]]]
"""Of each attribute its name, interpolation and values (rows, m), as USD holds it."""
RATE = 24.0
"""Time codes a second of a single time."""
NEAR = 1e-6
"""Time codes by which a moment may be off a whole one that is meant."""


def write(path: Path, strands: Strands, samples: Iterable[TimeSample] | None, beside: Layer | None = None) -> list[str]:
    """Write strands as linear curves; ``samples``: their points at several times, rising; ``beside``: other prims.
    Returns lines for what is left out. Raises `RefusedError` where it cannot be written."""
    there = pieces(strands, legal)
    attributes = [_attributes(one) for one in there.strands]
    lost = {name for _, left in attributes for name in left}
    kind = "usda" if path.suffix.lower() == ".usda" else "usdc"
    with placed(path, ".usd") as temporary:
        temporary.write_bytes(b"")
        temporary.unlink()
        request = {"do": "write", "temporary": str(temporary.absolute()), "format": kind}
        messages = _messages(path, strands, (there, [own for own, _ in attributes]), samples, beside)
        for _ in ask(path, request, messages):
            pass
    return left_out(strands, ".usd", strands.attributes.keys() - lost) + renamed(strands, legal, ".usd")


def legal(name: str) -> str:
    """A name with letters, digits and underscores alone, the first of them no digit, as prims have it."""
    found = "".join(letter if f"_{letter}".isidentifier() else "_" for letter in name)
    return found if not found or found.isidentifier() else f"_{found}"


def _messages(
    path: Path, strands: Strands, objects: tuple[Pieces, list[Attributes]], samples: Iterable[TimeSample] | None,
    beside: Layer | None,
) -> Iterator[Message]:  # fmt: skip
    """What the worker is to write: all but points, then these at each time; ``objects``: each with its attributes;
    ``beside``: other prims."""
    there, attributes = objects
    moments = checked(path, strands, samples, ".usd")
    first = next(moments)
    second = next(moments, None)
    rate = None if samples is None else RATE if second is None else _rate(second.seconds - first.seconds)
    source = strands.source
    up = source.up or "y"
    if up not in ("y", "z"):
        raise UsageError(f"{path}: USD knows y and z as up axes, not {up}; turn it with --up {up}")
    header = {
        "rate": rate, "up": up.upper(), "unit": source.unit or 1.0,
        "prims": [
            {"name": name, "attributes": [[theirs, interpolation] for theirs, interpolation, _ in own]}
            for name, own in zip(there.names, attributes, strict=True)
        ],
        "beside": beside(rate or RATE) if beside else "",
    }  # fmt: skip
    arrays: list[npt.NDArray[Any]] = []
    for one, own in zip(there.strands, attributes, strict=True):
        arrays += [one.counts("<i4"), *(values for _, _, values in own)]
    yield header, arrays
    widest = [max((float(values.max(initial=0.0)) for name, _, values in own if name == "widths"), default=0.0)
              for own in attributes]  # fmt: skip
    for moment in chain([first], [] if second is None else [second], moments):
        yield _points(there, moment, rate, widest)
    yield {"all": True}, []


def _rate(seconds: float) -> float:
    """Time codes a second of moments that are so far apart: a whole number where one is meant."""
    found = 1 / seconds
    whole = round(found)
    return float(whole) if whole and abs(found - whole) < 1e-4 * whole else float(f"{found:.12g}")


def time_code(seconds: float, rate: float) -> float:
    """The time code of a moment, of which ``rate`` are a second: a whole one where it is meant."""
    code = seconds * rate
    return float(round(code)) if abs(code - round(code)) < NEAR else code


def _points(there: Pieces, one: TimeSample, rate: float | None, widest: list[float]) -> Message:
    code = None if rate is None else time_code(one.seconds, rate)
    points = [own.astype("<f4", copy=False) for own in there.of(one.points)]
    return {"code": code, "extents": [_extent(*pair) for pair in zip(points, widest, strict=True)]}, points


def _extent(points: Points, widest: float) -> list[list[float]]:
    """Corners of the box about strands of points (P, 3)."""
    largest = float(np.finfo(np.float32).max)
    corners = box_of(points, np.inf) + np.array([[-widest / 2], [widest / 2]])
    corners = np.nan_to_num(corners, nan=0.0, posinf=largest, neginf=-largest)
    return np.asarray(np.clip(corners, -largest, largest)).tolist() if points.shape[0] else [[0.0] * 3] * 2


def _attributes(strands: Strands) -> tuple[Attributes, list[str]]:
    """Name, interpolation and values (rows, m) of what USD holds, and names of what it does not."""
    found: Attributes = []
    lost = []
    for name, one in strands.attributes.items():
        values = _values(strands, name, one)
        theirs = THEIRS.get(name, name)
        fine = theirs.replace("_", "a").isalnum() and theirs.isascii() and not theirs[0].isdigit()
        if values is None or not fine or any(theirs == other for other, _, _ in found):
            lost.append(name)
        else:
            found.append((theirs, INTERPOLATION[one.domain], values))
    return found, lost


def _values(strands: Strands, name: str, one: Attribute) -> npt.NDArray[Any] | None:
    """Values as (rows, m), in a type that USD has; None of the rest."""
    values = one.values
    if name in EXTENTS:
        each = EXTENTS[name]
        if values.size != each * values.shape[0] or values.dtype.kind not in "fiu":
            return None
        if values.dtype == np.uint8:
            values = values.astype(np.float32) / np.float32(255)
        values = values.astype(np.float32, copy=False).reshape(-1, each)
        return 1 - values if name == "transparency" else values
    rows = values.reshape(values.shape[0], -1) if values.size else values.reshape(0, 1)
    if rows.dtype.kind == "f" and rows.dtype.itemsize <= 4:
        return rows.astype(np.float32, copy=False) if rows.shape[1] <= 4 else None
    kind = KINDS.get(rows.dtype.char)
    return rows.astype(kind) if kind and rows.shape[1] == 1 else None
