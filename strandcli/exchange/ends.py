"""What roots and tips tell: which end of a strand is which, the up axis, and the unit.

Roots lie on a head, about a sphere, and tips do not; hair hangs; heads have a size. Each guess is one only where what
it rests on is clear.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .edit.transform import AXES, axis
from .strands import Mask, Strands

LEAST_STRANDS = 20
"""With fewer, nothing is guessed."""
ENOUGH = 20_000
"""Strands that spheres are fitted to, at most."""
CLEARER = 0.7
"""The misfit of roots is at most so much of that of tips."""
ON = 0.1
"""Misfit of roots that lie on a head, and how far from it one is on it, radii."""
OFF = 0.5
"""How far from the head an end is off it, radii: roots at the nape, on the neck, are .36 from the sphere of a scalp."""
MOST, ROUNDS = 0.9, 4
"""Share of the points that a sphere is fitted to, and how often anew: strands that run the other way are not."""
HANGS = 0.5
"""Cosine between hanging hair and down, at least; of the middle of the scalp and up, `CAP`."""
CAP = 0.2
HEAD = 0.1
"""Radius of a human head about the scalp, metres; within a factor of `LIKE`, a unit is believed."""
LIKE = 1.6
UNITS = {"metres": 1.0, "decimetres": 0.1, "inches": 0.0254, "centimetres": 0.01, "millimetres": 0.001}


@dataclass(frozen=True, slots=True)
class Sphere:
    """A sphere, and the root mean square of the distances of points that fit it, over its radius."""

    centre: npt.NDArray[np.float64]
    radius: float
    misfit: float

    def off(self, points: npt.NDArray[np.floating]) -> npt.NDArray[np.float64]:
        """How far points are from it, radii."""
        found: npt.NDArray[np.float64] = np.linalg.norm(points - self.centre, axis=1) / self.radius - 1
        return np.abs(found)


def sphere(points: npt.NDArray[np.floating]) -> Sphere:
    """The sphere through most points: fitted some times, each time to the points that were nearest to the last one, and
    first to those nearest to the middle: one point far away would make a sphere so large that all others lie on it."""
    points = points.astype(np.float64)  # whose squares overflow in single precision
    far = np.linalg.norm(points - np.median(points, axis=0), axis=1)
    found = _fitted(points[far <= np.quantile(far, MOST)])
    for _ in range(ROUNDS):
        off = found.off(points)
        found = _fitted(points[off <= np.quantile(off, MOST)])
    return found


def _fitted(points: npt.NDArray[np.floating]) -> Sphere:
    """The sphere of the least squares of |p|² − 2 c·p − (r² − |c|²)."""
    p = points.astype(np.float64)
    middle = p.mean(axis=0)
    p = p - middle
    size = float(np.sqrt((p * p).sum(axis=1).mean())) or 1.0
    p /= size
    solution = np.linalg.lstsq(np.column_stack([2 * p, np.ones(p.shape[0])]), (p * p).sum(axis=1), rcond=None)[0]
    centre = solution[:3]
    radius = float(np.sqrt(max(solution[3] + centre @ centre, 1e-30)))
    off = np.linalg.norm(p - centre, axis=1) - radius
    return Sphere(middle + size * centre, size * radius, float(np.sqrt((off * off).mean()) / radius))


@dataclass(frozen=True, slots=True)
class Ends:
    """Which end is the root: "first", "last" or "unknown"; the spheres through first and last points; strands (S,) that
    run the other way than the rest."""

    root: str
    first: Sphere
    last: Sphere
    others: Mask


def ends(strands: Strands) -> Ends | None:
    """Which end of finite strands is the root; None of too few."""
    if strands.count < LEAST_STRANDS:
        return None
    step = -(-strands.count // ENOUGH)
    first, last = sphere(strands.roots()[::step]), sphere(strands.tips()[::step])
    others = np.zeros(strands.count, np.bool_)
    root = "unknown"
    if min(first.misfit, last.misfit) < CLEARER * max(first.misfit, last.misfit):
        root = "first" if first.misfit < last.misfit else "last"
        head = first if root == "first" else last
        if head.misfit < ON:
            one, other = strands.roots(), strands.tips()
            one, other = (one, other) if root == "first" else (other, one)
            others = (head.off(one) > OFF) & (head.off(other) < ON)
    return Ends(root, first, last, others)


def up_axis(strands: Strands, found: Ends) -> tuple[str, float] | None:
    """The up axis, and the cosine between hanging hair and down; None where hair hangs from no scalp above it."""
    if found.root == "unknown":
        return None
    head = found.first if found.root == "first" else found.last
    one, other = strands.roots().astype(np.float64), strands.tips().astype(np.float64)
    one, other = (one, other) if found.root == "first" else (other, one)
    reach = np.linalg.norm(other - one, axis=1)
    usual = np.minimum(reach, np.quantile(reach, MOST))  # how much a strand counts: no single one decides
    ways = (other - one) / np.maximum(reach, 1e-30)[:, None]
    hanging = (usual @ ways) / max(float(usual.sum()), 1e-30)
    cap = (np.median(one, axis=0) - head.centre) / head.radius
    for name in AXES:
        if hanging @ axis(name) <= -HANGS and cap @ axis(name) >= CAP:
            return name, float(-(hanging @ axis(name)))
    return None


def unit(strands: Strands, found: Ends) -> dict[str, Any] | None:
    """The radius of the head that roots lie on, the unit in which it is a human one ("" where none is), and the factor
    to metres; None where roots lie on no head, or on a small part of one."""
    head = found.last if found.root == "last" else found.first
    if found.root == "unknown" or head.misfit > ON:
        return None
    low, high = np.percentile(strands.tips() if found.root == "last" else strands.roots(), [1, 99], axis=0)
    if np.sort(high - low)[1] < head.radius:
        return None
    for name, metres in UNITS.items():
        if 1 / LIKE <= head.radius * metres / HEAD <= LIKE:
            return {"radius": head.radius, "unit": name, "scale": metres}
    return {"radius": head.radius, "unit": "", "scale": HEAD / head.radius}
