"""Rest bends as `kernels.rest_shape` reads them, in frames that are parallel-transported along strands: those of the
emitted shape, and those with which strands are in equilibrium in it, with the stiffness that this requires.

A joint bent by b beyond its rest has the moment κ b for any b: rest bends need not lead to unit vectors. An equilibrium
of a soft groom is unstable: upright strands buckle, and level ones, whose natural shape is a coil of many turns, snap
into it when touched. So a strand is made stiffer (Derouet-Jourdan et al. 2010, "Stable Inverse Dynamic Curves") until
it does not buckle even if tilted by `TILT`, with `SAFETY` times its weight, and its natural shape turns away from the
emitted one by at most `TURNS`. Hanging strands, which tension stabilises, and stiff ones keep their material.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...constants import FOLD
from ...groom.record import Groom, frame

Floats = NDArray[np.float64]

COILED = 0.9
"""Distance between a strand's ends, as a share of its length, below which it counts as a coil."""


def transported(axes: Floats, edges: Floats, bends: Floats, angles: Floats) -> tuple[Floats, Floats]:
    """Return a unit vector perpendicular to each of the clamped directions ``axes``, (strands, 3), and ``bends``
    (N, strands, 3) in the frame of the edge before each joint: along that edge and along two normals.

    axes (strands, 3), edges and bends (N, strands, 3). Frames are parallel-transported along the edges and then turned
    around them by ``angles`` (N, strands); that of the clamp is not turned."""
    first = a = frame(axes)[0]
    t, local = axes, np.empty_like(bends)
    for j in range(len(edges)):
        if j > 0:
            e = edges[j - 1]
            a = a - ((a * e).sum(1) / np.maximum(1 + (t * e).sum(1), 1e-6))[:, None] * (t + e)
            a /= np.linalg.norm(a, axis=1, keepdims=True)
            t = e
        angle = (angles[j - 1] if j > 0 else np.zeros(len(axes)))[:, None]
        b = np.cross(t, a)
        frames = (t, a * np.cos(angle) + b * np.sin(angle), b * np.cos(angle) - a * np.sin(angle))
        local[j] = np.stack([(bends[j] * axis).sum(1) for axis in frames], 1)
    return first, local


def unit_edges(groom: Groom, n: int) -> tuple[list[Floats], bool]:
    """Return N arrays (strands, 3) of unit vectors of edges, root to tip, in the emitter's frame, and whether some had
    no length.

    An edge without length gets the direction of the one before it, the first that of the strand. If all strands are
    straight, all edges are the same array."""
    before = groom.directions.astype(np.float64)
    edges, mended = [], False
    for j in range(n):
        edge = groom.edge(j, n)
        lost = np.asarray(~edge.any(axis=1))
        if lost.any():
            edge, mended = np.where(lost[:, None], before, edge), True
        before = before if np.array_equal(edge, before) else edge  # straight strands share one array
        edges.append(before)
    return edges, mended


def coiled(edges: list[Floats]) -> bool:
    """Return whether any strand with these edges, (strands, 3) each, is a coil."""
    return float(np.linalg.norm(np.mean(edges, axis=0), axis=1).min()) < COILED


def straight(directions: list[Floats]) -> bool:
    """Return whether all directions, (strands, 3) each, are equal."""
    return all(a is b or np.abs(b - a).max() <= 1e-6 for a, b in pairwise(directions))


TILT = np.radians(30)
"""Tilt, radians, at which strands must not buckle."""
SAFETY = 1.5
"""Factor of their weight at this tilt."""
TURNS = np.pi / 2
"""Greatest angle, radians, between natural and emitted shape, times the root of `torsion` (Prandtl 1899)."""
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
