"""Small oscillations in double precision: frequencies and shapes of a clamped beam and of a hanging chain, as
eigenproblems of integral operators."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .quadrature import Array, Interval, interval


@dataclass(frozen=True)
class Modes:
    """The slowest modes of a strand of length 1."""

    nodes: Interval
    """In shares of the length from the root."""
    frequencies: Array
    """(m,) angular, ascending, in the problem's own unit."""
    shapes: Array
    """(n, m) displacements at the nodes; every column has a mean square of one, so that they are orthonormal."""

    def shares(self, positions: Array) -> Array:
        """(T, m): how much of each mode is in displacements (T, p) at p even places from the root, 0, to the tip."""
        places = np.linspace(0, 1, positions.shape[1])
        weights = np.full(len(places), 1.0)
        weights[[0, -1]] = 0.5  # of the trapezoidal rule, and the masses of a strand's particles as well
        shapes = self.nodes.at(self.shapes, places)
        return np.asarray(positions @ (weights[:, None] * shapes) / (len(places) - 1))


def beam(count: int, nodes: int = 48) -> Modes:
    """Clamped at the root, free at the tip: w⁗ = ω² w in units of √(B / (ρ A L⁴)). The moment is the weight of all
    beyond integrated twice from the tip, the displacement the curvature integrated twice from the root."""
    space = interval(nodes)
    return _modes(space, space.below @ space.below @ space.above @ space.above, count)


def chain(count: int, nodes: int = 48) -> Modes:
    """Hanging from its root without stiffness: (t u′)′ = −ω² u with t = 1 − s, in units of √(g / L). The slope is the
    inertia of all that hangs below over its weight."""
    space = interval(nodes)
    return _modes(space, space.below @ (space.above / (1 - space.nodes)[:, None]), count)


def _modes(space: Interval, inverse: Array, count: int) -> Modes:
    """The greatest eigenvalues 1 / ω² of an operator that gives the displacement under a load."""
    values, vectors = np.linalg.eig(inverse)
    order = np.argsort(-values.real)[:count]
    shapes = vectors[:, order].real
    shapes /= np.sqrt(space.weights @ shapes**2)
    return Modes(space, 1 / np.sqrt(values.real[order]), shapes)
