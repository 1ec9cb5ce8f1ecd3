"""Rest bends with which strands are in equilibrium in their emitted shape, and the stiffness that this requires.

Statics. A strand is statically determinate: from the tip to the root, tension and the difference of the moments at an
edge's ends balance all the weight beyond it, so the moments follow from shape and weight alone. A joint bent by b
beyond its rest has the moment κ b for any b: rest bends need not lead to unit vectors. The component of a moment along
an edge is balanced by twist, which turns the frames of the rest bends (`kernels.rest_shape`).

Stability. Every groom has such an equilibrium, but that of a soft one is unstable: upright strands buckle, and level
ones, whose natural shape is a coil of many turns, snap into it when touched. So the material is changed
(Derouet-Jourdan, Bertails-Descoubes & Thollot 2010, "Stable Inverse Dynamic Curves"): a strand is made stiffer until

- it does not buckle even if tilted by `TILT`, with `SAFETY` times its weight; and
- its natural shape turns away from the emitted one by at most `TURNS` everywhere.

Hanging strands, which tension stabilises, and stiff ones keep their material.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...constants import FOLD

Floats = NDArray[np.float64]

TILT = np.radians(30)
"""Tilt, radians, at which strands must not buckle."""
SAFETY = 1.5
"""Factor of their weight at this tilt."""
TURNS = np.pi / 2
"""Greatest angle, radians, between natural and emitted shape if torsional and bending rigidity are equal. It is
proportional to the square root of their ratio, as is the load of lateral buckling (Prandtl 1899)."""
HALVINGS = 40
"""Bisections of the range of the least stiffness, on a logarithmic scale."""


class Held(NamedTuple):
    """Rest bends and forces of strands in equilibrium."""

    bends: Floats
    """(N, strands, 3) bends beyond rest."""
    twist: Floats
    """(N, strands) twist angles of the frames of edges, radians."""
    tension: Floats
    """(N, strands) force densities of edges, over their mass."""
    stiffness: Floats
    """(strands,) of the joints, 1/s²; at least the given one."""


def hold(
    axes: Floats, edges: Floats, mass: Floats, joint: Floats, stiffness: Floats, torsion: float, pull: Floats
) -> Held:
    """Return rest bends, twist, tension and stiffness with which strands are in stable equilibrium.

    axes (strands, 3): unit vectors along which they are clamped; edges (N, strands, 3): unit vectors, root to tip; mass
    and joint (N,): relative masses of particles and rigidities of joints; stiffness (strands,): B / (ρ A ℓ⁴) in 1/s²;
    torsion: torsional over bending rigidity; pull (strands, 3): gravity in segments/s²."""
    forces, twist = np.zeros_like(edges), np.zeros(edges.shape[:2])
    tension, load = np.zeros_like(twist), np.zeros_like(twist)
    moment, weight = np.zeros_like(edges[0]), np.zeros_like(edges[0])
    after = weight  # force of the joint after, across its edge
    for j in reversed(range(len(edges))):
        e, before = edges[j], edges[j - 1] if j > 0 else axes
        weight = weight + mass[j] * pull
        along, size = (weight * e).sum(1), np.linalg.norm(weight, axis=1)
        tension[j] = along + (after * e).sum(1)
        off = np.arccos(np.clip(along / np.maximum(size, 1e-300), -1, 1))
        load[j] = tension[j] - along + size * np.cos(np.minimum(off + TILT, np.pi))
        # the moment of the weight beyond: its component along the edge twists, the rest bends
        moment = moment - np.cross(e, weight)
        twist[j] = (moment * e).sum(1)
        open = np.maximum(1 + (e * before).sum(1), FOLD)
        after = forces[j] = np.cross(e, moment - (twist[j] / open)[:, None] * (e + before))
    forces /= joint[:, None, None]
    turned = np.linalg.norm(np.cumsum(forces, axis=0), axis=2).max(0)
    enough = np.maximum(np.maximum(stiffness, turned / (TURNS * np.sqrt(torsion))), 1e-300)
    enough = _stable_stiffness(np.where(load < 0, SAFETY * load, load), joint, enough)
    twist = -np.cumsum(twist / (torsion * joint[:, None] * enough), axis=0)
    return Held(forces / enough[:, None], twist, tension, enough)


def _stable_stiffness(load: Floats, joint: Floats, stiffness: Floats) -> Floats:
    """Return (strands,) the least stiffness, at least the given one, at which strands with the tensions ``load``
    (N, strands) are stable."""
    weak = np.flatnonzero(~_stable(load, joint, stiffness))
    if not len(weak):
        return stiffness
    load, low = load[:, weak], stiffness[weak]
    # no chain of N joints is softer than (2 sin(π / (4 N + 2)))² > 1 / N² of its softest joint
    high = 2 * np.abs(load).max(0) * len(joint) ** 2 / float(joint.min())
    high = np.maximum(high, low)
    for _ in range(HALVINGS):
        middle = np.sqrt(low * high)
        stable = _stable(load, joint, middle)
        low, high = np.where(stable, low, middle), np.where(stable, middle, high)
    found = stiffness.copy()
    found[weak] = high
    return found


def _stable(load: Floats, joint: Floats, stiffness: Floats) -> NDArray[np.bool_]:
    """Return (strands,) whether strands are stable: whether the energy of small rotations v_j of edges, the sum of
    κ_j |v_j − v_{j−1}|² + load_j |v_j|², is positive definite, by the pivots of its tridiagonal matrix."""
    good = np.ones(len(stiffness), np.bool_)
    past = np.full(len(stiffness), np.inf)
    for j in range(len(joint)):
        here = stiffness * joint[j]
        after = stiffness * joint[j + 1] if j + 1 < len(joint) else 0.0
        pivot = here + after + load[j] - here / past * here
        good &= pivot > 0
        past = np.where(pivot > 0, pivot, np.inf)
    return good
