"""Rest bends by which strands hang still in the shape that they are emitted in, and how stiff they have to be for it.

Statics. A strand is statically determinate: from the tip to the root, all that hangs on an edge is its tension and the
difference of the moments at its ends, so the moments follow from shape and weight alone. A joint that is bent by b
beyond its rest gives the moment κ b, however large b is: the targets of bends need not lead to unit vectors. What of a
moment is about an edge turns the frames by which targets are carried (`kernels.rod_curl`).

Stability. Any groom can be balanced so, but a soft one as a pencil is on its tip, or a mousetrap: upright strands
buckle, and level ones, whose natural shape is then a coil of many turns, snap into it when touched. What rest shapes
cannot do is asked of the material (as by Derouet-Jourdan, Bertails-Descoubes & Thollot 2010, "Stable Inverse Dynamic
Curves"): a strand is made stiffer until

- it would not even buckle if it were tilted by `TILT`, all of its weight times `SAFETY`; and
- nowhere along it does its natural shape turn away from the emitted one by more than `TURNS`.

Strands that hang, which tension holds in place, and stiff ones stay as they are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..constants import FOLD

Floats = NDArray[np.float64]

TILT = np.radians(30)
SAFETY = 1.5
TURNS = np.pi / 2
"""Radians for a torsional rigidity that is that of bending; with its root, as loads go under which beams tip sideways
(Prandtl 1899)."""
HALVINGS = 40
"""Of the range in which the least stiffness lies, on a scale of logarithms."""


class Held(NamedTuple):
    """What holds strands in their shape."""

    bends: Floats
    """(N, strands, 3) bends beyond rest."""
    twist: Floats
    """(N, strands) angles, in radians, by which twist has turned the frames of edges."""
    tension: Floats
    """(N, strands) force densities of edges, over their mass."""
    stiffness: Floats
    """(strands,) of the joints, 1/s²; never less than was given."""


def hold(
    axes: Floats, edges: Floats, mass: Floats, joint: Floats, stiffness: Floats, torsion: float, pull: Floats
) -> Held:  # fmt: skip
    """What holds strands still that are clamped along ``axes`` (strands, 3) and whose unit ``edges`` are (N, strands,
    3), root to tip, of particles' relative ``mass`` and joints' relative rigidity ``joint``, (N,) both, and of
    ``stiffness`` (strands,) B / (ρ A ℓ⁴) in 1/s² and ``torsion`` times that against twist, under the ``pull``
    (strands, 3) of gravity in segments/s²."""
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
        # of the moment that carries all beyond, what is about the edge is twist, the rest bends
        moment = moment - np.cross(e, weight)
        twist[j] = (moment * e).sum(1)
        open = np.maximum(1 + (e * before).sum(1), FOLD)
        after = forces[j] = np.cross(e, moment - (twist[j] / open)[:, None] * (e + before))
    forces /= joint[:, None, None]
    turned = np.linalg.norm(np.cumsum(forces, axis=0), axis=2).max(0)
    enough = np.maximum(np.maximum(stiffness, turned / (TURNS * np.sqrt(torsion))), 1e-300)
    enough = _stand(np.where(load < 0, SAFETY * load, load), joint, enough)
    twist = -np.cumsum(twist / (torsion * joint[:, None] * enough), axis=0)
    return Held(forces / enough[:, None], twist, tension, enough)


def _stand(load: Floats, joint: Floats, stiffness: Floats) -> Floats:
    """(strands,) the least stiffness, from that given on, at which strands of these tensions (N, strands) stand."""
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
    """(strands,) whether the energy of turning edges aside, κ_j |v_j − v_{j−1}|² and load_j |v_j|², is positive: by the
    pivots of its matrix."""
    good = np.ones(len(stiffness), np.bool_)
    past = np.full(len(stiffness), np.inf)
    for j in range(len(joint)):
        here = stiffness * joint[j]
        after = stiffness * joint[j + 1] if j + 1 < len(joint) else 0.0
        pivot = here + after + load[j] - here / past * here
        good &= pivot > 0
        past = np.where(pivot > 0, pivot, np.inf)
    return good
