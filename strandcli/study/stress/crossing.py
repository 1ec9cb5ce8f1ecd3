"""Whether strands pass through each other, found apart from what the rule `contact` makes of it.

Segments that go on straight ways from the begin to the end of each part of a step pass through each other where their
four ends lie in a plane, a root of a cubic, and they cross in it (Provot 1997). Of closed curves the linking number
tells, whatever their ways: it changes where one passes through the other (Klenin and Langowski 2000).
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SHARES = np.array([0.0, 1 / 3, 2 / 3, 1.0])
FIT = np.linalg.inv(np.vander(SHARES, 4))
"""Of a cubic through values at `SHARES`."""
REAL = 1e-9
"""Imaginary part of a root that counts as real."""

MET = 1e-6
"""Distance at which segments count as crossing, over their lengths."""


class Passing:
    """Watches a rod solver with contact: the parts of its steps that it keeps."""

    def __init__(self, solver: Any) -> None:
        self._parts: list[tuple[float, Floats, Floats]] = []
        self.contact = contact = solver.contact
        make = contact.step

        def step(run: Callable[[], None], dt: float, solver: Any) -> bool:
            time = solver._moment[0]
            begin = time - dt * (1 - 1e-6)
            while self._parts and self._parts[-1][0] > begin:  # a step that was undone, for it was too long
                self._parts.pop()
            before = contact._particles(solver.state)
            done = bool(make(run, dt, solver))
            self._parts.append((time, before, contact._particles(solver.state)))
            return done

        contact.step = step

    def count(self) -> float:
        """How many pairs of segments have passed through each other so far."""
        return float(sum(passed(start, end) for _, start, end in self._parts))


def passed(start: Floats, end: Floats) -> int:
    """Pairs of segments of different strands that pass through each other on straight ways, (S, N + 1, 3)."""
    if not (np.isfinite(start).all() and np.isfinite(end).all()):
        return 0
    count, way = 0, end - start
    for s, t in combinations(range(len(start)), 2):
        at = [start + share * way for share in SHARES]
        volumes = np.stack([_volumes(x[s], x[t]) for x in at], -1)
        for i, j in np.argwhere((volumes.min(-1) <= 0) & (volumes.max(-1) >= 0)):
            ends = tuple(x[k, m : m + 2] for k, m in ((s, i), (t, j)) for x in (start, way))
            count += _meet(volumes[i, j], *ends)
    return count


def _volumes(x: Floats, y: Floats) -> Floats:
    """(N, N) volumes between each segment of one strand and each of another."""
    e, f = np.diff(x, axis=0), np.diff(y, axis=0)
    return np.asarray(np.einsum("ijc,ijc->ij", np.cross(e[:, None], f[None]), y[None, :-1] - x[:-1, None]))


def _meet(volumes: Floats, p: Floats, p_way: Floats, q: Floats, q_way: Floats) -> bool:
    """Whether two segments (2, 3) on their ways cross where their volume is none."""
    for root in np.roots(FIT @ volumes):
        if abs(root.imag) < REAL and 0 < root.real <= 1:
            one, other = p + root.real * p_way, q + root.real * q_way
            basis = np.stack([one[1] - one[0], other[0] - other[1]], 1)
            apart = other[0] - one[0]
            places, *_ = np.linalg.lstsq(basis, apart, rcond=None)
            # parallel ones lie in a plane and yet do not meet
            met = np.linalg.norm(basis @ places - apart) <= MET * np.linalg.norm(basis)
            if met and (places >= 0).all() and (places <= 1).all():
                return True
    return False


def linking(a: Floats, b: Floats) -> float:
    """The linking number of two closed polygons (n, 3) and (m, 3), whole but for rounding: Gauss's integral."""
    p, q = np.roll(a, -1, 0)[:, None], np.roll(b, -1, 0)[None]
    a, b = a[:, None], b[None]
    corners = [np.cross(b - a, q - a), np.cross(q - a, q - p), np.cross(q - p, b - p), np.cross(b - p, b - a)]
    normals = [_unit(one) for one in corners]
    angles = sum(
        np.arcsin(np.clip((one * other).sum(-1), -1, 1))
        for one, other in zip(normals, normals[1:] + normals[:1], strict=True)
    )
    turn = np.sign((np.cross(q - b, p - a) * (b - a)).sum(-1))
    return float((angles * turn).sum() / (4 * np.pi))


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300))
