"""Solids that have no kernels of their own, in kernels that take `Solids` of either type.

Where these hold none of them the functions are compiled to nothing; where they do, to those of `distance_field` with
the functions that the type has.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from ...jit import device, inlined
from ...jit.pruned import by_type
from ...meshes.kernels.ray_packet import RAYS
from ...simd.local import local_float64
from ..shapes.other import KIND
from . import distance_field as field
from . import segment_depth, soft_edge
from .distance_field import INF, ZERO, ray_in_own, through, trace


def form_of(solids):
    """The class of a type of `Solids`, which has the compiled functions of its shapes; None where it has none."""
    found = getattr(solids, "instance_class", None)
    return found if hasattr(found, "distance") else None


def _has(part):
    """A function that tells whether the shapes of `Solids` have a part."""

    def found(solids):
        there = getattr(form_of(solids), part, None) is not None
        return lambda solids: there

    return by_type(found)


has_look = _has("look")
"""Whether any of the shapes of these has a look of its own."""
takes_vectors = _has("distances_in_own")
"""Whether `walk` can be called: all of these have distances of vectors."""
has_slopes = _has("slopes_in_own")
"""Whether `nearest_slope` can be called: all of these have distances of vectors with their gradients."""


@by_type
def count(solids):
    """How many of the `Solids` there are of these."""
    if form_of(solids) is None:
        return lambda solids: 0
    return lambda solids: solids.others.shape[0]


@by_type
def meet(solids, m, ox, oy, oz, dx, dy, dz):
    """`distance_field.trace` of number m of these."""
    form = form_of(solids)
    if form is None:
        return lambda solids, m, ox, oy, oz, dx, dy, dz: INF
    distance, first, among = form.distance, form.meet, form.among
    return lambda solids, m, ox, oy, oz, dx, dy, dz: trace(distance, first, among(solids), m, ox, oy, oz, dx, dy, dz)


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


@inlined
def trace_together(distance, meets, p, m, rays, found):
    """Write to `found` what `distance_field.trace` returns for each of the `RAYS` rays, by `meets`; rays are lost."""
    starts = local_float64()
    for k in range(RAYS):
        ox, oy, oz, dx, dy, dz = ray_of(rays, k)
        t, end = through(p, m, ox, oy, oz, dx, dy, dz)
        starts[k] = t
        x, y, z = ox + t * dx, oy + t * dy, oz + t * dz
        misses = end < t or (t == ZERO and distance(p, m, x, y, z) < ZERO)
        found[k] = -1.0 if misses else np.inf
        put_ray(rays, k, ray_in_own(p, m, x, y, z, dx, dy, dz))
    meets(p, m, rays, found)
    for k in range(RAYS):
        found[k] = np.float32(starts[k]) + np.float32(found[k]) if found[k] >= 0.0 else INF


@inlined
def trace_each(distance, meet, p, m, rays, found):
    """The same by `distance_field.trace`."""
    for k in range(RAYS):
        ox, oy, oz, dx, dy, dz = ray_of(rays, k)
        found[k] = trace(distance, meet, p, m, ox, oy, oz, dx, dy, dz)


@by_type
def trace_rays(solids, m, rays, found):
    """`meet` of the rays of a pixel: together, or one by one."""
    form = form_of(solids)
    if form is None:
        return lambda solids, m, rays, found: None
    distance, first, meets, among = form.distance, form.meet, form.meets, form.among
    if meets is None:
        return lambda solids, m, rays, found: trace_each(distance, first, among(solids), m, rays, found)
    return lambda solids, m, rays, found: trace_together(distance, meets, among(solids), m, rays, found)


@by_type
def normal(solids, m, x, y, z):
    """Unit outward normal of number m of these at a point of its surface."""
    form = form_of(solids)
    if form is None:
        return lambda solids, m, x, y, z: (ZERO, field.ONE, ZERO)

    outward, among, look = form.normal, form.among, form.look
    if look is not None:
        none, width, first = (ZERO, ZERO, ZERO), ZERO, np.int64(-1)
        return lambda solids, m, x, y, z: look(among(solids), m, x, y, z, none, width, first)[0]

    def found(solids, m, x, y, z):
        nx, ny, nz = outward(among(solids), m, x, y, z)
        return np.float32(nx), np.float32(ny), np.float32(nz)

    return found


@by_type
def look(solids, m, x, y, z, eye, width, before):
    """The normal, the place and the colour of number m of these, and a number, as `SolidShape.look_after`, in the
    world."""
    form = form_of(solids)
    if form is None or form.look is None:
        none = (ZERO, ZERO, ZERO)
        return lambda solids, m, x, y, z, eye, width, before: (none, none, none, before)
    found, among = form.look, form.among
    return lambda solids, m, x, y, z, eye, width, before: found(among(solids), m, x, y, z, eye, width, before)


@by_type
def folds(solids, m):
    """Whether number m of these may hide parts of itself."""
    form = form_of(solids)
    if form is None or not any(form.folds):
        return lambda solids, m: False
    kinds = form.folds
    return lambda solids, m: kinds[int(solids.others[m, KIND])]


@by_type
def visibility(solids, x, y, z, lx, ly, lz, reach, skin):
    """Return 1 if none of these solids is between a point, moved by `skin` along the unit vector l, and a light at the
    distance `reach`, metres; else 0."""
    form = form_of(solids)
    if form is None:
        return lambda solids, x, y, z, lx, ly, lz, reach, skin: field.ONE
    hides, among = form.hides, form.among
    return lambda solids, x, y, z, lx, ly, lz, reach, skin: field.visibility_past_all(
        hides, among(solids), x, y, z, (lx, ly, lz), reach, skin
    )


@by_type
def lowest_sine(solids, x, y, z, way, light):
    """`soft_edge.least_sine` of all of these; `CLEAR` where there are none."""
    form = form_of(solids)
    if form is None:
        return lambda solids, x, y, z, way, light: soft_edge.CLEAR
    distance_in_own, among, parts = form.distance_in_own, form.among, parts_of(form)
    return lambda solids, x, y, z, way, light: soft_edge.least_sine_of_all(
        distance_in_own, parts, among(solids), x, y, z, way, light
    )


def parts_of(form):
    """The parts of the way through a solid's ball that a search for its edge looks at, at the least."""
    return soft_edge.FINE_ACROSS if form.detailed else soft_edge.ACROSS


@by_type
def outside(solids, x, y, z, clear):
    """A point, moved to `clear` metres off the surfaces of these."""
    form = form_of(solids)
    if form is None:
        return lambda solids, x, y, z, clear: (x, y, z)
    distance, outward, among = form.distance, form.normal, form.among
    return lambda solids, x, y, z, clear: field.put_outside_all(distance, outward, among(solids), x, y, z, clear)


@by_type
def least_distance(solids, x, y, z):
    """A distance, metres, that no surface of these is nearer than; negative inside of one."""
    form = form_of(solids)
    if form is None:
        return lambda solids, x, y, z: INF
    distance, among = form.distance, form.among
    return lambda solids, x, y, z: field.least_distance_of_all(distance, among(solids), x, y, z)


@by_type
def deepest(solids, positions, b):
    """Greatest depth of a block's particles in these and of its segments, metres."""
    form = form_of(solids)
    if form is None:
        return lambda solids, positions, b: (ZERO, ZERO)
    distance, place, among = form.distance, form.deepest, form.among
    return lambda solids, positions, b: segment_depth.deepest_of_block(distance, place, among(solids), positions, b)


@by_type
def deepen(solids, x, y, z, most):
    """The greatest of depths and of those of points in these, metres; vectors of lanes."""
    form = form_of(solids)
    if form is None:
        return lambda solids, x, y, z, most: most
    distance, distances, among = form.distance, form.distances_in_own, form.among
    if distances is not None:
        return lambda solids, x, y, z, most: segment_depth.deepen_vectors(distances, among(solids), x, y, z, most)
    return lambda solids, x, y, z, most: segment_depth.deepen_lanes(distance, among(solids), x, y, z, most)


@partial(by_type, jit_options={"forceinline": True})
def nearest_slope(solids, x, y, z):
    """The distances of points from the nearest of these, metres, and their gradients there; vectors of lanes."""
    form = form_of(solids)
    if form is None or form.slopes_in_own is None:
        return lambda solids, x, y, z: (x, x, x, x)
    slopes, among = form.slopes_in_own, form.among
    return lambda solids, x, y, z: segment_depth.nearest_slope_of_all(slopes, among(solids), x, y, z)


@by_type
def begin_walk(solids, m, point, way, light):
    """`soft_edge.begin` of number m of these; nothing to walk where they have no distances of vectors."""
    form = form_of(solids)
    if form is None or form.distances_in_own is None:
        return lambda solids, m, point, way, light: (
            (point[0], point[1], point[2], way[0], way[1], way[2]), light[0], light[0]
        )  # fmt: skip
    bounds, among, parts = form.bounds, form.among, parts_of(form)
    return lambda solids, m, point, way, light: soft_edge.begin(bounds, parts, among(solids), m, point, way, light)


@by_type
def walk(solids, m, some, others, most):
    """`soft_edge.walk` of number m of these."""
    form = form_of(solids)
    if form is None or form.distances_in_own is None:
        return lambda solids, m, some, others, most: (some[1], some[3], others[1], others[3])
    distances, among, parts = form.distances_in_own, form.among, parts_of(form)
    return lambda solids, m, some, others, most: soft_edge.walk(distances, parts, among(solids), m, some, others, most)


@by_type
def walk_alone(solids, m, ray, most):
    """`soft_edge.walk_alone` of number m of these."""
    form = form_of(solids)
    if form is None or form.distances_in_own is None:
        return lambda solids, m, ray, most: (ray[1], ray[3])
    distances, among, parts = form.distances_in_own, form.among, parts_of(form)
    return lambda solids, m, ray, most: soft_edge.walk_alone(distances, parts, among(solids), m, ray, most)
