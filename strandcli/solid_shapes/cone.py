"""A truncated cone about its own y axis: a cone, a frustum, a cylinder where both radii are the same.

Points are taken in the half plane of the axis, q away from it: there the solid is a quadrangle of the axis, the two
caps and the side, which goes from (radius, -h) to (top, h).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ..scene.fields import choice, number
from ..scene.model.solids import SolidSettings

kind = "cone"
convex = True
TINY = 1e-12


@dataclass(frozen=True, slots=True, repr=False)
class Settings(SolidSettings):
    """A truncated cone along its own y axis; a cylinder where `top` is as `radius`."""

    kind: str = choice("cone", ("cone",))
    radius: float = number(0.5, above=0, unit="m", doc="radius of its lower end")
    top: float = number(0.0, low=0, unit="m", doc="radius of its upper end")
    length: float = number(1.0, above=0, unit="m", doc="distance between its two ends")


def numbers(settings: Settings) -> tuple[float, ...]:
    """Both radii, half the length h, the side's outward normal (across, up) in the half plane, the side's length."""
    slope = settings.radius - settings.top
    side = math.hypot(settings.length, slope)
    return settings.radius, settings.top, settings.length / 2, settings.length / side, slope / side, side


def reach(settings: Settings) -> float:
    """Distance of the farther edge from the middle."""
    return math.hypot(settings.length / 2, max(settings.radius, settings.top))


def distance(x: Any, y: Any, z: Any, p: Any) -> Any:
    """Exact: inside from the nearest of three lines, outside from the nearer of the side and a cap."""
    radius, top, h, across, up, side = p
    q = math.sqrt(x * x + z * z)
    off = across * (q - radius) + up * (y + h)
    over = abs(y) - h
    if off <= 0 and over <= 0:
        return max(off, over)
    along = across * (y + h) - up * (q - radius)
    past = along - min(max(along, 0.0), side)
    beside = max(q - (top if y > 0 else radius), 0.0)
    return math.sqrt(min(off * off + past * past, over * over + beside * beside))


def normal(x: Any, y: Any, z: Any, p: Any) -> Any:
    """That of a cap, of the side, or away from the edge that is nearest. On the axis one across it."""
    radius, top, h, across, up, side = p
    q = math.sqrt(x * x + z * z)
    off = across * (q - radius) + up * (y + h)
    over = abs(y) - h
    along = across * (y + h) - up * (q - radius)
    n, m = across, up
    if over > off and (over <= 0 or q <= (top if y > 0 else radius)):
        n, m = 0.0, 1.0 if y > 0 else -1.0
    elif (off > 0 or over > 0) and not 0 <= along <= side:
        dq, dy = (q - radius, y + h) if along < 0 else (q - top, y - h)
        if dq * dq + dy * dy > TINY * h * h:
            n, m = dq, dy
    if q > TINY * h:
        return n * x / q, m, n * z / q
    return n, m, 0.0


def meet(x: Any, y: Any, z: Any, dx: Any, dy: Any, dz: Any, p: Any) -> Any:
    """By the slab between the caps, then on the side by the first root of a t² + 2 b t + c, c > 0, from there on."""
    radius, top, h, _, _, _ = p
    t, end = 0.0, math.inf
    if dy != 0:
        t = max((-h - y) / dy if dy > 0 else (h - y) / dy, 0.0)
        end = (h - y) / dy if dy > 0 else (-h - y) / dy
    elif abs(y) > h:
        return math.inf
    if end < t:
        return math.inf
    slope = (top - radius) / (2 * h)
    x, z = x + t * dx, z + t * dz
    r = radius + slope * (y + t * dy + h)
    a = dx * dx + dz * dz - slope * slope * dy * dy
    b = x * dx + z * dz - slope * dy * r
    c = x * x + z * z - r * r
    if c <= 0:
        return t
    square = b * b - a * c
    if square < 0 or (b >= 0 and a >= 0):
        return math.inf
    t += c / (math.sqrt(square) - b) if b < 0 else (math.sqrt(square) + b) / -a
    return t if t <= end else math.inf
