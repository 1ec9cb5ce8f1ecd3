"""One small step of extended position-based dynamics (Macklin, Müller & Chentanez 2016; Macklin et al. 2019).

State in double precision, in the blocks of `strandcli.blocks` without the row before the root: x (blocks, n, 3 W), the
root first. Masses are relative to a segment's, ρ A ℓ, and stiffness to it as well: κ = B / (ρ A ℓ⁴) in 1/s².
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from numpy.typing import NDArray

from ....constants import W
from ....jit import function, parallel, prange
from ....solids.kernels import box as box_kernel
from ....solids.kernels import capsule as capsule_kernel
from ....solids.kernels import plane as plane_kernel
from ....solids.kernels import sphere as sphere_kernel

STEP, GRAVITY, AIR, DRAG, DAMPING = 0, 1, 4, 7, 8
"""Places of numbers: length of a step, s, gravity (3), m/s², velocity of the air (3), m/s, drag, 1/s, and damping of
the material, s."""

sphere = function(sphere_kernel.collide)
capsule = function(capsule_kernel.collide)
plane = function(plane_kernel.collide)
box = function(box_kernel.collide)


class Material(NamedTuple):
    """What strands are made of, in double precision; constant during a step."""

    clamp: NDArray[Any]
    """(blocks, 3 W) unit directions at the roots."""
    lengths: NDArray[Any]
    """(blocks, W) of a segment, metres."""
    stiffness: NDArray[Any]
    """(blocks, W) κ, 1/s²."""
    light: NDArray[Any]
    """(n,) inverse masses, 0 where a particle is held."""
    joint: NDArray[Any]
    """(n − 1,) rigidity of the joint before each segment over that of the rod."""


@parallel
def step(x, v, before, material, gust, numbers, held, solids):
    """Move every strand by one step, in place.

    v (blocks, n, 3 W) m/s; before as x: previous positions, whose row 0 the driver has set, as it has moved the root;
    material: a `Material`; gust (blocks, W): factor of the air's velocity; numbers (9,): as `STEP` and the others say;
    held (3,): position of a held tip, or (0,); solids: four arrays as in `strandcli.solids`.
    """
    for b in prange(x.shape[0]):
        n = x.shape[1]
        predict(x[b], v[b], before[b], gust[b], numbers)
        if held.shape[0] > 0:
            for c in range(3):
                for k in range(W):
                    x[b, n - 1, c * W + k] = held[c]
        stiffness = material.stiffness[b]
        lean(
            x[b], before[b], material.clamp[b], material.lengths[b], stiffness, material.light[1], material.joint[0],
            numbers,
        )  # fmt: skip
        for i in range(1, n - 1):
            bend(x[b], before[b], i, stiffness, material.light, material.joint[i], numbers)
        for i in range(1, n):
            stretch(x[b, i - 1], x[b, i], material.lengths[b], material.light[i - 1], material.light[i])
        for i in range(1, n):
            sphere(x[b, i], x[b, i], x[b, i], x[b, 0], material.lengths[b], solids[0], i, n)
            capsule(x[b, i], x[b, i], x[b, i], x[b, 0], material.lengths[b], solids[1], i, n)
            plane(x[b, i], x[b, i], x[b, i], x[b, 0], material.lengths[b], solids[2], i, n)
            box(x[b, i], x[b, i], x[b, i], x[b, 0], material.lengths[b], solids[3], i, n)
        per = 1 / numbers[STEP]
        for i in range(n):
            for j in range(3 * W):
                v[b, i, j] = (x[b, i, j] - before[b, i, j]) * per


@function
def predict(x, v, before, gust, numbers):
    """x += h v, v having taken in gravity and, implicitly, drag: v' = (v + h (g + drag air)) / (1 + h drag)."""
    h = numbers[STEP]
    drag = numbers[DRAG]
    slow = 1 / (1 + h * drag)
    for i in range(1, x.shape[0]):
        for c in range(3):
            pull = h * numbers[GRAVITY + c]
            push = h * drag * numbers[AIR + c]
            for k in range(W):
                j = c * W + k
                before[i, j] = x[i, j]
                x[i, j] += h * (v[i, j] + pull + push * gust[k]) * slow


@function
def lean(x, before, clamp, lengths, stiffness, light, joint, numbers):
    """The clamp: energy ½ κ |x_1 − x_0 − ℓ d|², as one exact step of its own with its damping."""
    h = numbers[STEP]
    held = 1 + numbers[DAMPING] / h
    for c in range(3):
        for k in range(W):
            j = c * W + k
            e = x[1, j] - x[0, j]
            bent = e - lengths[k] * clamp[j] + numbers[DAMPING] / h * (e - (before[1, j] - before[0, j]))
            s = stiffness[k] * joint * h * h
            x[1, j] -= light * s * bent / (1 + s * held * light)


@function
def bend(x, before, i, stiffness, light, joint, numbers):
    """Joint i: energy ½ κ |x_{i+1} − 2 x_i + x_{i−1}|², each coordinate a constraint of compliance 1 / (κ h²)."""
    h = numbers[STEP]
    damp = numbers[DAMPING] / h
    a = light[i - 1]
    m = light[i]
    z = light[i + 1]
    total = (1 + damp) * (a + 4 * m + z)
    for c in range(3):
        for k in range(W):
            j = c * W + k
            d = x[i + 1, j] - 2 * x[i, j] + x[i - 1, j]
            d += damp * (d - (before[i + 1, j] - 2 * before[i, j] + before[i - 1, j]))
            s = stiffness[k] * joint * h * h
            f = s * d / (1 + s * total)
            x[i - 1, j] -= a * f
            x[i, j] += 2 * m * f
            x[i + 1, j] -= z * f


@function
def stretch(a, b, lengths, light_a, light_b):
    """|b − a| = ℓ, shared out by inverse masses. Coincident particles are not moved."""
    total = light_a + light_b
    for k in range(W):
        dx = b[k] - a[k]
        dy = b[W + k] - a[W + k]
        dz = b[2 * W + k] - a[2 * W + k]
        size = math.sqrt(dx * dx + dy * dy + dz * dz)
        f = (size - lengths[k]) / (size * total) if size * total > 0 else 0.0
        a[k] += light_a * f * dx
        a[W + k] += light_a * f * dy
        a[2 * W + k] += light_a * f * dz
        b[k] -= light_b * f * dx
        b[W + k] -= light_b * f * dy
        b[2 * W + k] -= light_b * f * dz
