"""Solids that have no kernels of their own, in kernels that take `Solids` of either type.

Where these hold none of them the functions are compiled to nothing; where they do, to those of `distance_field` with
the functions that the type has.
"""

from __future__ import annotations

import inspect

import numpy as np

from ...jit import device, inlined
from ...jit.pruned import by_type
from ...meshes.kernels.rays import RAYS
from ...simd.local import local_float64
from ..shapes.other import KIND
from . import distance_field as field
from . import segment_depth, soft_edge
from .distance_field import INF, ZERO, ray_in_own, through, trace


def form_of(solids):
    """The class of a type of `Solids`, which has the compiled functions of its shapes; None where it has none."""
    found = getattr(solids, "instance_class", None)
    return found if hasattr(found, "distance") else None


def by_form(otherwise, part="distance", **options):
    """A decorator: kernels that call the function call what it returns for the class of the `Solids` that come first,
    or ``otherwise`` where that has no such part, a function of the same parameters."""

    def decorate(make):
        def choose(*types):
            form = form_of(types[0])
            return otherwise if getattr(form, part, None) is None else make(form)

        choose.__signature__ = inspect.signature(otherwise)
        return by_type(choose, **options)

    return decorate


def _has(part):
    """A function that tells whether the shapes of `Solids` have a part."""
    return by_form(lambda solids: False, part)(lambda form: lambda solids: True)


has_look = _has("look")
"""Whether any of the shapes of these has a look of its own."""
takes_vectors = _has("distances_in_own")
"""Whether `walk` can be called: all of these have distances of vectors."""
has_slopes = _has("slopes_in_own")
"""Whether `nearest_slope` can be called: all of these have distances of vectors with their gradients."""


@by_form(lambda solids: 0)
def count(form):
    """How many of the `Solids` there are of these."""
    return lambda solids: solids.others.shape[0]


@by_form(lambda solids, m, ox, oy, oz, dx, dy, dz: INF)
def meet(form):
    """`distance_field.trace` of number m of these."""
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


@by_form(lambda solids, m, rays, found: None)
def trace_rays(form):
    """`meet` of the rays of a pixel: together, or one by one."""
    distance, first, meets, among = form.distance, form.meet, form.meets, form.among
    if meets is None:
        return lambda solids, m, rays, found: trace_each(distance, first, among(solids), m, rays, found)
    return lambda solids, m, rays, found: trace_together(distance, meets, among(solids), m, rays, found)


@by_form(lambda solids, m, x, y, z: (ZERO, field.ONE, ZERO))
def normal(form):
    """Unit outward normal of number m of these at a point of its surface."""
    outward, among, look = form.normal, form.among, form.look
    if look is not None:
        none, width, first = (ZERO, ZERO, ZERO), ZERO, np.int64(-1)
        return lambda solids, m, x, y, z: look(among(solids), m, x, y, z, none, width, first)[0]

    def found(solids, m, x, y, z):
        nx, ny, nz = outward(among(solids), m, x, y, z)
        return np.float32(nx), np.float32(ny), np.float32(nz)

    return found


NOWHERE = (ZERO, ZERO, ZERO)


@by_form(lambda solids, m, x, y, z, eye, width, before: (NOWHERE, NOWHERE, NOWHERE, before), "look")
def look(form):
    """The normal, the place and the colour of number m of these, and a number, as `SolidShape.look`, in the world."""
    found, among = form.look, form.among
    return lambda solids, m, x, y, z, eye, width, before: found(among(solids), m, x, y, z, eye, width, before)


def may_fold(solids):
    """Whether a type of `Solids` has shapes that may hide parts of themselves."""
    form = form_of(solids)
    return form is not None and any(form.folds)


@by_form(lambda solids, m: False)
def folds(form):
    """Whether number m of these may hide parts of itself."""
    kinds = form.folds
    if not any(kinds):
        return lambda solids, m: False
    return lambda solids, m: kinds[int(solids.others[m, KIND])]


@by_form(lambda solids, x, y, z, lx, ly, lz, reach, skin: field.ONE)
def visibility(form):
    """Return 1 if none of these solids is between a point, moved by `skin` along the unit vector l, and a light at the
    distance `reach`, metres; else 0."""
    hides, among = form.hides, form.among
    return lambda solids, x, y, z, lx, ly, lz, reach, skin: field.visibility_past_all(
        hides, among(solids), x, y, z, (lx, ly, lz), reach, skin
    )


def parts_of(form):
    """The parts of the way through a solid's ball that a search for its edge looks at, at the least."""
    return soft_edge.FINE_ACROSS if form.detailed else soft_edge.ACROSS


@by_form(lambda solids, x, y, z, way, light: soft_edge.CLEAR)
def lowest_sine(form):
    """`soft_edge.least_sine` of all of these; `CLEAR` where there are none."""
    distance_in_own, among, parts = form.distance_in_own, form.among, parts_of(form)
    return lambda solids, x, y, z, way, light: soft_edge.least_sine_of_all(
        distance_in_own, parts, among(solids), x, y, z, way, light
    )


@by_form(lambda solids, x, y, z, clear: (x, y, z))
def outside(form):
    """A point, moved to `clear` metres off the surfaces of these."""
    distance, outward, among = form.distance, form.normal, form.among
    return lambda solids, x, y, z, clear: field.put_outside_all(distance, outward, among(solids), x, y, z, clear)


@by_form(lambda solids, x, y, z: INF)
def least_distance(form):
    """A distance, metres, that no surface of these is nearer than; negative inside of one."""
    distance, among = form.distance, form.among
    return lambda solids, x, y, z: field.least_distance_of_all(distance, among(solids), x, y, z)


@by_form(lambda solids, positions, b: (ZERO, ZERO))
def deepest(form):
    """Greatest depth of a block's particles in these and of its segments, metres."""
    distance, place, among = form.distance, form.deepest, form.among
    return lambda solids, positions, b: segment_depth.deepest_of_block(distance, place, among(solids), positions, b)


@by_form(lambda solids, x, y, z, most: most)
def deepen(form):
    """The greatest of depths and of those of points in these, metres; vectors of lanes."""
    distance, distances, among = form.distance, form.distances_in_own, form.among
    if distances is not None:
        return lambda solids, x, y, z, most: segment_depth.deepen_vectors(distances, among(solids), x, y, z, most)
    return lambda solids, x, y, z, most: segment_depth.deepen_lanes(distance, among(solids), x, y, z, most)


@by_form(lambda solids, x, y, z: (x, x, x, x), "slopes_in_own", jit_options={"forceinline": True})
def nearest_slope(form):
    """The distances of points from the nearest of these, metres, and their gradients there; vectors of lanes."""
    slopes, among = form.slopes_in_own, form.among
    return lambda solids, x, y, z: segment_depth.nearest_slope_of_all(slopes, among(solids), x, y, z)


@by_form(
    lambda solids, m, point, way, light: (
        (point[0], point[1], point[2], way[0], way[1], way[2]), light[0], light[0]
    ), "distances_in_own",
)  # fmt: skip
def begin_walk(form):
    """`soft_edge.begin` of number m of these; nothing to walk where they have no distances of vectors."""
    bounds, among, parts = form.bounds, form.among, parts_of(form)
    return lambda solids, m, point, way, light: soft_edge.begin(bounds, parts, among(solids), m, point, way, light)


@by_form(lambda solids, m, some, others, most: (some[1], some[3], others[1], others[3]), "distances_in_own")
def walk(form):
    """`soft_edge.walk` of number m of these."""
    distances, among, parts = form.distances_in_own, form.among, parts_of(form)
    return lambda solids, m, some, others, most: soft_edge.walk(distances, parts, among(solids), m, some, others, most)


@by_form(lambda solids, m, ray, most: (ray[1], ray[3]), "distances_in_own")
def walk_alone(form):
    """`soft_edge.walk_alone` of number m of these."""
    distances, among, parts = form.distances_in_own, form.among, parts_of(form)
    return lambda solids, m, ray, most: soft_edge.walk_alone(distances, parts, among(solids), m, ray, most)
