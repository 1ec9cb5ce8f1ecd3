"""Strands of several objects of curves, one after the other, where transforms put them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from .splines import ControlCurves, Fitter
from .strands import CACHED, OBJECT, WIDTHS, Attribute, Domain, Offsets, Points, Source, Strands, offsets

RANK: dict[Domain, int] = {"groom": 0, "strand": 1, "point": 2}
"""Domains, from few values to many."""
Matrix = npt.NDArray[np.float64]
"""(4, 4), of rows: a point (x, y, z, 1) is multiplied from the left."""


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """What an object of curves holds: its name in full, points of each curve (S,), points (P, 3), attributes by our
    names, names of those that are none here."""

    name: str

    counts: Offsets
    points: Points
    attributes: dict[str, Attribute] = field(default_factory=dict)
    unread: list[str] = field(default_factory=list)


def part_of(
    name: str, curves: ControlCurves, control: Points, fitter: Fitter, matrix: Matrix | None,
    values: Iterable[tuple[str, str, npt.NDArray[Any] | None]],
) -> Part:  # fmt: skip
    """The points on curves of control points (P, 3), where a matrix puts them; ``values``: of each attribute our name,
    what it belongs to, a key of `INTERPOLATIONS` or "", and rows of numbers, None for what is no numbers."""
    attributes: dict[str, Attribute] = {}
    unread = []
    for label, interpolation, rows in values:
        found = None if rows is None or label in attributes else curves.attribute(label, interpolation, rows)
        if found is None:
            unread.append(label)
        else:
            attributes[label] = found if matrix is None else moved_attribute(label, found, matrix)
    points, departure = curves.points(control)
    fitter.departure = max(fitter.departure, departure)
    return Part(name, curves.point_counts(), moved(points, matrix), attributes, unread)


def joined(parts: list[Part], source: Source) -> tuple[Strands, list[str]]:
    """The strands of all parts, which are let go, and the names of attributes that not all of them have alike."""
    names = tuple(one.name for one in parts)
    every = [one.attributes for one in parts]
    lost = {name: None for one in parts for name in one.unread}
    counts, points_of = [one.counts for one in parts], [one.points for one in parts]
    parts.clear()
    points = concatenated(points_of)
    attributes: dict[str, Attribute] = {}
    for name in {name: None for one in every for name in one}:
        found = _attribute([one.pop(name, None) for one in every], counts)
        if found is None:
            lost[name] = None
        else:
            attributes[name] = found
    if len(names) > 1:
        if OBJECT in attributes:
            lost[OBJECT] = None
        numbers = np.repeat(np.arange(len(names), dtype=np.int32), [one.size for one in counts])
        attributes[OBJECT] = Attribute("strand", numbers)
    return Strands(offsets(concatenated(counts)), points, attributes, source, names), sorted(lost)


def concatenated(arrays: list[npt.NDArray[Any]]) -> npt.NDArray[Any]:
    """Arrays one after the other; each is let go as soon as it was copied."""
    if len(arrays) == 1:
        return arrays.pop()
    kind = np.result_type(*{one.dtype for one in arrays})
    found = np.empty((sum(map(len, arrays)), *arrays[0].shape[1:]), kind)
    end = len(found)
    while arrays:
        one = arrays.pop()
        found[end - len(one) : end] = one
        end -= len(one)
    return found


def _attribute(found: list[Attribute | None], counts: list[Offsets]) -> Attribute | None:
    """An attribute of all parts, in the domain that has a value for each of theirs; None where they differ in type."""
    there = [one for one in found if one is not None]
    found.clear()
    if len(there) != len(counts) or len({(one.values.dtype, one.values.shape[1:]) for one in there}) > 1:
        return None
    if len(there) == 1:
        return there[0]
    domain = max((one.domain for one in there), key=lambda one: max(RANK[one], RANK["strand"]))
    target: Literal["point", "strand"] = "point" if domain == "point" else "strand"
    there.reverse()
    return Attribute(target, concatenated([_values(there.pop(), each, target) for each in counts]))


def _values(one: Attribute, counts: Offsets, domain: Domain) -> npt.NDArray[Any]:
    """Values for each strand or point of strands of so many points (S,)."""
    values = one.values
    if one.domain == "groom":
        values = np.repeat(values, counts.shape[0], axis=0)
    if domain == "point" and one.domain != "point":
        values = np.repeat(values, counts, axis=0)
    return values


def moved(points: npt.NDArray[np.float32], matrix: Matrix | None) -> npt.NDArray[np.float32]:
    """Points (P, 3) where a transform puts them."""
    if matrix is None:
        return points
    found = np.empty_like(points)
    with np.errstate(over="ignore", invalid="ignore"):
        for begin in range(0, points.shape[0], CACHED):  # of more, threads of BLAS wait for one another
            found[begin : begin + CACHED] = points[begin : begin + CACHED] @ matrix[:3, :3] + matrix[3, :3]
    return found


def turned(normals: npt.NDArray[np.float32], matrix: Matrix) -> npt.NDArray[np.float32]:
    """Normals (P, 3) as a transform turns them, as long as they were."""
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        cofactors = np.cross(matrix[[1, 2, 0], :3], matrix[[2, 0, 1], :3])
        found = normals @ cofactors * np.sign(np.linalg.det(matrix[:3, :3]))  # the inverse transposed, but for length
        long, now = np.linalg.norm(normals, axis=1, keepdims=True), np.linalg.norm(found, axis=1, keepdims=True)
        return np.asarray(np.where(now > 0, found * (long / now), normals).astype(np.float32))


def moved_attribute(name: str, one: Attribute, matrix: Matrix) -> Attribute:
    """An attribute as a transform leaves it: widths are scaled, normals turned."""
    if name in WIDTHS and one.values.dtype == np.float32:
        with np.errstate(over="ignore", invalid="ignore"):
            scale = abs(float(np.linalg.det(matrix[:3, :3]))) ** (1 / 3)
            return Attribute(one.domain, (one.values * scale).astype(np.float32))
    if name == "normal" and one.values.shape[1:] == (3,) and one.values.dtype == np.float32:
        return Attribute(one.domain, turned(one.values, matrix))
    return one
