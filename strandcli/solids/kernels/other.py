"""Solids that have no kernels of their own, in kernels that take `Solids` of either type.

Where these hold none of them the functions are compiled to nothing; where they do, to those of `distance_field` with
the functions that the type has.
"""

from __future__ import annotations

import numpy as np
from numba.extending import overload

from ..shapes.other import KIND
from . import distance_field as field
from . import pixel_rays, segment_depth, soft_edge


def form_of(solids):
    """The class of a type of `Solids`, which has the compiled functions of its shapes; None where it has none."""
    found = getattr(solids, "instance_class", None)
    return found if hasattr(found, "distance") else None


def count(solids):
    """How many of the `Solids` there are of these."""


@overload(count)
def _count(solids):
    if form_of(solids) is None:
        return lambda solids: 0
    return lambda solids: solids.others.shape[0]


def meet(solids, m, ox, oy, oz, dx, dy, dz):
    """`distance_field.trace` of number m of these."""


@overload(meet)
def _meet(solids, m, ox, oy, oz, dx, dy, dz):
    form = form_of(solids)
    if form is None:
        return lambda solids, m, ox, oy, oz, dx, dy, dz: field.INF
    distance, first, among = form.distance, form.meet, form.among
    return lambda solids, m, ox, oy, oz, dx, dy, dz: field.trace(
        distance, first, among(solids), m, ox, oy, oz, dx, dy, dz
    )


def trace_rays(solids, m, rays, found):
    """`meet` of the rays of a pixel: `pixel_rays.trace_rays` of number m of these, or one by one."""


@overload(trace_rays)
def _trace_rays(solids, m, rays, found):
    form = form_of(solids)
    if form is None:
        return lambda solids, m, rays, found: None
    distance, first, meets, among = form.distance, form.meet, form.meets, form.among
    if meets is None:
        return lambda solids, m, rays, found: pixel_rays.trace_each(distance, first, among(solids), m, rays, found)
    return lambda solids, m, rays, found: pixel_rays.trace_rays(distance, meets, among(solids), m, rays, found)


def normal(solids, m, x, y, z):
    """Unit outward normal of number m of these at a point of its surface."""


@overload(normal)
def _normal(solids, m, x, y, z):
    form = form_of(solids)
    if form is None:
        return lambda solids, m, x, y, z: (field.ZERO, field.ONE, field.ZERO)

    outward, among, look = form.normal, form.among, form.look
    if look is not None:
        none, width, first = (field.ZERO, field.ZERO, field.ZERO), field.ZERO, np.int64(-1)
        return lambda solids, m, x, y, z: look(among(solids), m, x, y, z, none, width, first)[0]

    def found(solids, m, x, y, z):
        nx, ny, nz = outward(among(solids), m, x, y, z)
        return np.float32(nx), np.float32(ny), np.float32(nz)

    return found


def has_look(solids):
    """Whether any of the shapes of these has a look of its own."""


@overload(has_look)
def _has_look(solids):
    form = form_of(solids)
    found = form is not None and form.look is not None
    return lambda solids: found


def look(solids, m, x, y, z, eye, width, before):
    """The normal, the place and the colour of number m of these, and a number, as `SolidShape.look_after`, in the
    world."""


@overload(look)
def _look(solids, m, x, y, z, eye, width, before):
    form = form_of(solids)
    if form is None or form.look is None:
        none = (field.ZERO, field.ZERO, field.ZERO)
        return lambda solids, m, x, y, z, eye, width, before: (none, none, none, before)
    found, among = form.look, form.among
    return lambda solids, m, x, y, z, eye, width, before: found(among(solids), m, x, y, z, eye, width, before)


def folds(solids, m):
    """Whether number m of these may hide parts of itself."""


@overload(folds)
def _folds(solids, m):
    form = form_of(solids)
    if form is None or not any(form.folds):
        return lambda solids, m: False
    kinds = form.folds
    return lambda solids, m: kinds[int(solids.others[m, KIND])]


def visibility(solids, x, y, z, lx, ly, lz, reach, skin):
    """Return 1 if none of these solids is between a point, moved by `skin` along the unit vector l, and a light at the
    distance `reach`, metres; else 0."""


@overload(visibility)
def _visibility(solids, x, y, z, lx, ly, lz, reach, skin):
    form = form_of(solids)
    if form is None:
        return lambda solids, x, y, z, lx, ly, lz, reach, skin: field.ONE
    hides, among = form.hides, form.among
    return lambda solids, x, y, z, lx, ly, lz, reach, skin: field.visibility_past_all(
        hides, among(solids), x, y, z, (lx, ly, lz), reach, skin
    )


def lowest_sine(solids, x, y, z, way, light):
    """`soft_edge.least_sine` of all of these; `CLEAR` where there are none."""


@overload(lowest_sine)
def _lowest_sine(solids, x, y, z, way, light):
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


def takes_vectors(solids):
    """Whether `other_edges` can be called: all of these have distances of vectors."""


@overload(takes_vectors)
def _takes_vectors(solids):
    form = form_of(solids)
    found = form is not None and form.distances_in_own is not None
    return lambda solids: found


def outside(solids, x, y, z, clear):
    """A point, moved to `clear` metres off the surfaces of these."""


@overload(outside)
def _outside(solids, x, y, z, clear):
    form = form_of(solids)
    if form is None:
        return lambda solids, x, y, z, clear: (x, y, z)
    distance, outward, among = form.distance, form.normal, form.among
    return lambda solids, x, y, z, clear: field.put_outside_all(distance, outward, among(solids), x, y, z, clear)


def least_distance(solids, x, y, z):
    """A distance, metres, that no surface of these is nearer than; negative inside of one."""


@overload(least_distance)
def _least_distance(solids, x, y, z):
    form = form_of(solids)
    if form is None:
        return lambda solids, x, y, z: field.INF
    distance, among = form.distance, form.among
    return lambda solids, x, y, z: field.least_distance_of_all(distance, among(solids), x, y, z)


def deepest(solids, positions, b):
    """Greatest depth of a block's particles in these and of its segments, metres."""


@overload(deepest)
def _deepest(solids, positions, b):
    form = form_of(solids)
    if form is None:
        return lambda solids, positions, b: (field.ZERO, field.ZERO)
    distance, place, among = form.distance, form.deepest, form.among
    return lambda solids, positions, b: segment_depth.deepest_of_block(distance, place, among(solids), positions, b)


def deepen(solids, x, y, z, most):
    """The greatest of depths and of those of points in these, metres; vectors of lanes."""


@overload(deepen)
def _deepen(solids, x, y, z, most):
    form = form_of(solids)
    if form is None:
        return lambda solids, x, y, z, most: most
    distance, distances, among = form.distance, form.distances_in_own, form.among
    if distances is not None:
        return lambda solids, x, y, z, most: segment_depth.deepen_vectors(distances, among(solids), x, y, z, most)
    return lambda solids, x, y, z, most: segment_depth.deepen_lanes(distance, among(solids), x, y, z, most)


def has_slopes(solids):
    """Whether `nearest_slope` can be called: all of these have distances of vectors with their gradients."""


@overload(has_slopes)
def _has_slopes(solids):
    form = form_of(solids)
    found = form is not None and form.slopes_in_own is not None
    return lambda solids: found


def nearest_slope(solids, x, y, z):
    """The distances of points from the nearest of these, metres, and their gradients there; vectors of lanes."""


@overload(nearest_slope, jit_options={"forceinline": True})
def _nearest_slope(solids, x, y, z):
    form = form_of(solids)
    if form is None or form.slopes_in_own is None:
        return lambda solids, x, y, z: (x, x, x, x)
    slopes, among = form.slopes_in_own, form.among
    return lambda solids, x, y, z: segment_depth.nearest_slope_of_all(slopes, among(solids), x, y, z)
