"""The change of the force densities against the dense system that it solves."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from strandcli.blocks import aligned
from strandcli.constants import VECTOR
from strandcli.simd import vector_pointer_at
from strandcli.simulate.kernels import rod_descent, rod_tension
from strandcli.simulate.kernels.rod import DI, FIRST, N1, N2, SEGMENT, E, T

LANES = VECTOR // 8


@njit(error_model="numpy")
def change(address, n, mass, joint):
    """Add to τ what the Newton step asks for."""
    pile = vector_pointer_at(np.float64, address)
    rod_tension.observe(pile, n, mass, False)
    rod_descent.descend(pile, n, mass, joint, True, None, True)


@pytest.mark.parametrize("n", [1, 2, 9, 40])
def test_it_solves_the_dense_system(n: int) -> None:
    rng = np.random.default_rng(n)
    scratch = aligned((rod_tension.size_for(n), LANES), np.float64)
    rows = scratch[FIRST : FIRST + n * SEGMENT].reshape(n, SEGMENT, LANES)
    rows[:, DI] = rng.uniform(0.1, 1.0, (n, LANES))
    rows[:, N1] = rng.uniform(0.0, 1.0, (n, LANES))
    rows[:, N2] = rng.uniform(0.0, 0.5, (n, LANES))
    rows[:, E : E + 3] = rng.normal(size=(n, 3, LANES))
    given = rows.copy()
    change(scratch.ctypes.data, n, np.ones(n), np.ones(n))
    for lane in range(LANES):
        np.testing.assert_allclose(rows[:, T, lane], dense(given[..., lane]), rtol=1e-9, atol=1e-9)


def dense(rows: np.ndarray) -> np.ndarray:
    """S⁻¹ r of a lane's segments, (n, SEGMENT)."""
    n = len(rows)
    # z_j − i κ z_{j−1} + i B Σ_{k<j} z_k is noise
    steps = np.eye(n) + np.tril(np.ones((n, n)), -1) * rows[:, N2, None]
    steps[np.arange(1, n), np.arange(n - 1)] -= rows[1:, N1]
    back = np.linalg.inv(steps)
    edges = rows[:, E : E + 3]
    s = (edges @ edges.T) * (back @ np.diag(rows[:, DI]) @ back.T)
    q = (edges**2).sum(1)
    s += np.diag(np.maximum(1 / 16 - q, 0))
    return np.linalg.solve(s, np.where(q > 0.25, q * (np.sqrt(q) - 1), 0.5 * (q - 1)))
