"""Custom solids, in kernels that take `Solids` of any type.

Where these hold none of them the functions are compiled to nothing; where they do, to those of `distance_field`,
`segment_depth` and `soft_edge`. What the shapes of a type do not need is not compiled for it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...constants import W
from ...jit import device, function
from ...jit.pruned import by_type
from ...meshes.kernels.rays import RAYS
from ...simd.local import local_float64
from ..custom import KIND
from . import distance_field as field
from . import segment_depth, soft_edge
from .distance_field import INF, ONE, ZERO, ray_in_own, through

NOWHERE = (ZERO, ZERO, ZERO)
FIRST = np.int64(-1)


def form_of(solids: Any) -> Any:
    """The class of the custom solids that a type of `Solids` holds, which has the functions of their shapes; None where
    it holds none."""
    return getattr(getattr(solids, "instance_class", None), "custom_class", None)


def by_form(otherwise: Any, part: str = "distance_in_own", inline: bool = False) -> Any:
    """A decorator: kernels that call the function call what it returns for the class of the custom solids among the
    `Solids` that come first, or ``otherwise`` where that has no such part."""

    def decorate(make: Callable[..., Any]) -> Any:
        def choose(solids: Any, *rest: Any) -> Any:
            form = form_of(solids)
            return otherwise if getattr(form, part, None) is None else make(form)

        return by_type(choose, inline, strict=False)

    return decorate


def of_custom(function: Any, otherwise: Any, part: str = "distance_in_own", inline: bool = False) -> Any:
    """A function of `Solids` and more: ``function`` of the custom ones among them, as `by_form` has it."""

    @by_form(otherwise, part, inline)
    def make(form: Any) -> Any:
        among = form.among
        return lambda solids, *given: function(among(solids), *given)

    return make


def _has(part):
    """A function that tells whether the shapes of `Solids` have a part."""
    return by_form(lambda solids: False, part)(lambda form: lambda solids: True)


has_look = _has("look")
"""Whether any of the shapes of these has a look of its own."""


def may_fold(solids):
    """Whether a type of `Solids` has shapes that may hide parts of themselves."""
    form = form_of(solids)
    return form is not None and any(form.folds)


@by_form(lambda solids: 0)
def count(form):
    """How many of the `Solids` there are of these."""
    return lambda solids: solids.custom.shape[0]


meet = of_custom(field.trace, lambda solids, m, ox, oy, oz, dx, dy, dz: INF)
"""`distance_field.trace` of number m of these."""


@device
def ray_of(rays, k):
    """Origin and direction of a ray, in single precision; rays: six rows of `RAYS` numbers."""
    return (
        np.float32(rays[k]), np.float32(rays[RAYS + k]), np.float32(rays[2 * RAYS + k]),
        np.float32(rays[3 * RAYS + k]), np.float32(rays[4 * RAYS + k]), np.float32(rays[5 * RAYS + k]),
    )  # fmt: skip


@device
def put_ray(rays, k, ray):
    """Write origin and direction of a ray."""
    rays[k], rays[RAYS + k], rays[2 * RAYS + k] = ray[0], ray[1], ray[2]
    rays[3 * RAYS + k], rays[4 * RAYS + k], rays[5 * RAYS + k] = ray[3], ray[4], ray[5]


@device
def trace_together(p, m, rays, found):
    """Write to `found` what `distance_field.trace` returns for each of the `RAYS` rays, by `meets`; rays are lost."""
    starts = local_float64()
    for k in range(RAYS):
        ox, oy, oz, dx, dy, dz = ray_of(rays, k)
        t, end = through(p, m, ox, oy, oz, dx, dy, dz)
        starts[k] = t
        x, y, z = ox + t * dx, oy + t * dy, oz + t * dz
        misses = end < t or (t == ZERO and field.distance(p, m, x, y, z) < ZERO)
        found[k] = -1.0 if misses else np.inf
        put_ray(rays, k, ray_in_own(p, m, x, y, z, dx, dy, dz))
    field.meets(p, m, rays, found)
    for k in range(RAYS):
        found[k] = np.float32(starts[k]) + np.float32(found[k]) if found[k] >= 0.0 else INF


@device
def trace_each(p, m, rays, found):
    """The same by `distance_field.trace`."""
    for k in range(RAYS):
        ox, oy, oz, dx, dy, dz = ray_of(rays, k)
        found[k] = field.trace(p, m, ox, oy, oz, dx, dy, dz)


@by_form(lambda solids, m, rays, found: None)
def trace_rays(form):
    """`meet` of the rays of a pixel: together, or one by one."""
    among, trace = form.among, trace_each if form.meets is None else trace_together
    return lambda solids, m, rays, found: trace(among(solids), m, rays, found)


@by_form(lambda solids, m, x, y, z: (ZERO, ONE, ZERO))
def normal(form):
    """Unit outward normal of number m of these at a point of its surface."""
    among = form.among
    if form.look is not None:
        return lambda solids, m, x, y, z: field.look(among(solids), m, x, y, z, NOWHERE, ZERO, FIRST)[0]

    def found(solids, m, x, y, z):
        nx, ny, nz = field.normal(among(solids), m, x, y, z)
        return np.float32(nx), np.float32(ny), np.float32(nz)

    return found


look = of_custom(field.look, lambda solids, m, x, y, z, eye, width, before: (NOWHERE, NOWHERE, NOWHERE, before), "look")
"""The normal, the place and the colour of number m of these, and a number, as `SolidShape.look`, in the world."""


@by_form(lambda solids, m: False)
def folds(form):
    """Whether number m of these may hide parts of itself."""
    kinds = form.folds
    if not any(kinds):
        return lambda solids, m: False
    return lambda solids, m: kinds[int(solids.custom[m, KIND])]


VISIBLE = lambda solids, x, y, z, lx, ly, lz, reach, skin: ONE  # noqa: E731
visibility = of_custom(field.visibility_past_all, VISIBLE)
"""1 if none of these solids is between a point, moved by `skin` along the unit vector l, and a light at the distance
`reach`, metres; else 0."""


def parts_of(form):
    """The parts of the path through a solid's ball that a search for its edge looks at, at the least."""
    return soft_edge.FINE_ACROSS if form.detailed else soft_edge.ACROSS


outside = of_custom(field.put_outside_all, lambda solids, x, y, z, clear: (x, y, z))
"""A point, moved to `clear` metres off the surfaces of these."""
deepest = of_custom(segment_depth.deepest_of_block, lambda solids, positions, b: (ZERO, ZERO))
"""Greatest depth of a block's particles in these and of its segments, metres."""


deepen = of_custom(segment_depth.deepen, lambda solids, x, y, z, most: most)
"""The greatest of depths and of those of points in these, metres; vectors of lanes."""
nearest_slope = of_custom(
    segment_depth.nearest_slope_of_all, lambda solids, x, y, z: (x, x, x, x), "slopes_in_own", inline=True
)
"""The distances of points from the nearest of these, metres, and their gradients there; vectors of lanes."""


@by_form(
    lambda solids, m, point, direction, light: (
        (point[0], point[1], point[2], direction[0], direction[1], direction[2]), light[0], light[0]
    ), inline=True,
)  # fmt: skip
def begin_walk(form):
    """`soft_edge.begin` of number m of these; nothing to walk where there are none."""
    among, parts = form.among, parts_of(form)
    return lambda solids, m, point, direction, light: soft_edge.begin(parts, among(solids), m, point, direction, light)


@by_form(lambda solids, m, some, rest: (some[3], rest[3]))
def walk(form):
    """`soft_edge.walk` of number m of these."""
    among, parts = form.among, parts_of(form)
    return lambda solids, m, some, rest: soft_edge.walk(parts, among(solids), m, some, rest)


@function
def distances(p, m, points, out):
    """Write the distances (k,) of points (k, 3) from solid m of custom solids."""
    for k in range(points.shape[0]):
        out[k] = field.distance(p, m, points[k, 0], points[k, 1], points[k, 2])


def collide(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """Put particles inside of custom solids onto their surfaces, as `sphere.collide`."""
    for m in range(p.rows.shape[0]):
        for k in range(W):
            x[k], x[W + k], x[2 * W + k] = field.put_outside(p, m, x[k], x[W + k], x[2 * W + k], ZERO)


def catch(x: Any, parent: Any, grandparent: Any, root: Any, length: Any, p: Any, i: int, n: int) -> None:
    """Bring segments out of custom solids by turning them."""
    for m in range(p.rows.shape[0]):
        for k in range(W):
            begin = parent[k], parent[W + k], parent[2 * W + k]
            x[k], x[W + k], x[2 * W + k] = segment_depth.put_segment_outside(p, m, begin, x[k], x[W + k], x[2 * W + k])
