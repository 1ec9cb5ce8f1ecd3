"""Solids with a look of their own: normals for shading, where shadow rays begin, and colours from point to point."""

from __future__ import annotations

import math

import numpy as np

from ....jit import device
from ....solids.kernels import built_in, custom
from ...common.kernels.batch import EX, X, set_vector, vector_at
from ...common.kernels.numbers import ONE, ZERO
from ...common.kernels.surface_batch import ALBEDO, BEFORE, LIFT, NX, PIXEL

LEAST = np.float32(0.05)
"""Least cosine between the normal and the eye: where a smooth normal is turned away further, it is bent back, so that
no facet that is seen is shaded from behind."""


@device
def folds(solids, which):
    """Return whether solid number `which` may have edges in front of itself."""
    return which >= built_in.count(solids) and custom.folds(solids, which - built_in.count(solids))


def face_plain(solids, work, n, m):
    """Store unit normals of points of custom solid m."""
    for k in range(n):
        x, y, z = vector_at(work, X, k)
        set_vector(work, NX, k, custom.normal(solids, m, x, y, z))


@custom.by_form(face_plain, "look")
def face_custom(form):
    """`face_plain`, or where some have a look of their own `face_by_look`."""
    return face_by_look


def face_by_look(solids, work, n, m):
    """Store unit normals, lifts and colours of points of custom solid m."""
    before = np.int64(-1)
    for k in range(n):
        x, y, z = vector_at(work, X, k)
        if work[BEFORE + k] >= ZERO:
            before = np.int64(work[BEFORE + k])
        eye = vector_at(work, EX, k)
        normal, place, colour, before = custom.look(solids, m, x, y, z, eye, work[PIXEL + k], before)
        set_vector(work, NX, k, towards(normal, eye))
        set_vector(work, LIFT, k, (place[0] - x, place[1] - y, place[2] - z))
        if min(colour[0], min(colour[1], colour[2])) >= ZERO:
            set_vector(work, ALBEDO, k, colour)


@device
def towards(normal, eye):
    """Return a unit normal, bent until it faces the eye."""
    nx, ny, nz = normal
    facing = nx * eye[0] + ny * eye[1] + nz * eye[2]
    if facing >= LEAST:
        return nx, ny, nz
    nx += (LEAST - facing) * eye[0]
    ny += (LEAST - facing) * eye[1]
    nz += (LEAST - facing) * eye[2]
    size = ONE / math.sqrt(nx * nx + ny * ny + nz * nz)
    return nx * size, ny * size, nz * size
