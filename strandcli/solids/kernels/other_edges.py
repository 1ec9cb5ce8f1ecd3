"""How near lights are to the edges of solids without kernels of their own, by distances of vectors; as in `other`."""

from __future__ import annotations

from numba.extending import overload

from . import soft_edge
from .other import form_of, parts_of


def begin(solids, m, point, way, light):
    """`soft_edge.begin` of number m of these; nothing to walk where they have no distances of vectors."""


@overload(begin)
def _begin(solids, m, point, way, light):
    form = form_of(solids)
    if form is None or form.distances_in_own is None:
        return lambda solids, m, point, way, light: (
            (point[0], point[1], point[2], way[0], way[1], way[2]), light[0], light[0]
        )  # fmt: skip
    bounds, among, parts = form.bounds, form.among, parts_of(form)
    return lambda solids, m, point, way, light: soft_edge.begin(bounds, parts, among(solids), m, point, way, light)


def walk(solids, m, some, others, most):
    """`soft_edge.walk` of number m of these."""


@overload(walk)
def _walk(solids, m, some, others, most):
    form = form_of(solids)
    if form is None or form.distances_in_own is None:
        return lambda solids, m, some, others, most: (some[1], some[3], others[1], others[3])
    distances, among, parts = form.distances_in_own, form.among, parts_of(form)
    return lambda solids, m, some, others, most: soft_edge.walk(distances, parts, among(solids), m, some, others, most)


def walk_alone(solids, m, ray, most):
    """`soft_edge.walk_alone` of number m of these."""


@overload(walk_alone)
def _walk_alone(solids, m, ray, most):
    form = form_of(solids)
    if form is None or form.distances_in_own is None:
        return lambda solids, m, ray, most: (ray[1], ray[3])
    distances, among, parts = form.distances_in_own, form.among, parts_of(form)
    return lambda solids, m, ray, most: soft_edge.walk_alone(distances, parts, among(solids), m, ray, most)


def free_depth(solids, point, way, farthest, light):
    """`soft_edge.free_depth` of all of these; `farthest` where they have no distances of vectors."""


@overload(free_depth)
def _free_depth(solids, point, way, farthest, light):
    form = form_of(solids)
    if form is None or form.distances_in_own is None:
        return lambda solids, point, way, farthest, light: farthest
    distances, among, parts = form.distances_in_own, form.among, parts_of(form)

    def found(solids, point, way, farthest, light):
        p = among(solids)
        for m in range(p.rows.shape[0]):
            farthest = soft_edge.free_depth(distances, parts, p, m, point, way, farthest, light)
        return farthest

    return found
