"""The change of the force densities against the dense system that it solves."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from strandcli.blocks import aligned
from strandcli.constants import VECTOR
from strandcli.simd import vector_pointer_at
from strandcli.simulate.kernels import rod_elimination, rod_tension
from strandcli.simulate.kernels.rod_scratch import (
    EDGE,
    EDGE_FACTOR,
    FIRST_SEGMENT,
    INVERSE_PIVOT,
    PARTICLE_FACTOR,
    SEGMENT,
    TENSION,
)

LANES = VECTOR // 8


@njit(error_model="numpy")
def change(address, n, mass, joint):
    """Add to τ what the Newton step asks for."""
    pile = vector_pointer_at(np.float64, address)
    rod_tension.filter_forward(pile, n, mass, False, True, None)
    rod_elimination.change_tension(pile, n, mass, joint, False)


@pytest.mark.parametrize("n", [1, 2, 9, 40])
def test_it_solves_the_dense_system(n: int) -> None:
    rng = np.random.default_rng(n)
    scratch = aligned((rod_tension.scratch_size(n), LANES), np.float64)
    rows = scratch[FIRST_SEGMENT : FIRST_SEGMENT + n * SEGMENT].reshape(n, SEGMENT, LANES)
    rows[:, INVERSE_PIVOT] = rng.uniform(0.1, 1.0, (n, LANES))
    rows[:, EDGE_FACTOR] = rng.uniform(0.0, 1.0, (n, LANES))
    rows[:, PARTICLE_FACTOR] = rng.uniform(0.0, 0.5, (n, LANES))
    rows[:, EDGE : EDGE + 3] = rng.normal(size=(n, 3, LANES))
    given = rows.copy()
    change(scratch.ctypes.data, n, np.ones(n), np.ones(n))
    for lane in range(LANES):
        np.testing.assert_allclose(rows[:, TENSION, lane], dense(given[..., lane]), rtol=1e-9, atol=1e-9)


def dense(rows: np.ndarray) -> np.ndarray:
    """S⁻¹ r of a lane's segments, (n, SEGMENT)."""
    n = len(rows)
    # z_j − i κ z_{j−1} + i B Σ_{k<j} z_k is noise
    steps = np.eye(n) + np.tril(np.ones((n, n)), -1) * rows[:, PARTICLE_FACTOR, None]
    steps[np.arange(1, n), np.arange(n - 1)] -= rows[1:, EDGE_FACTOR]
    back = np.linalg.inv(steps)
    edges = rows[:, EDGE : EDGE + 3]
    s = (edges @ edges.T) * (back @ np.diag(rows[:, INVERSE_PIVOT]) @ back.T)
    q = (edges**2).sum(1)
    s += np.diag(np.maximum(1 / 16 - q, 0))
    return np.linalg.solve(s, np.where(q > 0.25, q * (np.sqrt(q) - 1), 0.5 * (q - 1)))
