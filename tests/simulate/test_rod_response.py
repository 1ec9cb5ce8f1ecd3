"""The response of a strand to forces of contact against the dense system that it solves."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from strandcli.blocks import aligned
from strandcli.constants import VECTOR
from strandcli.simd import store, vector_pointer_at
from strandcli.simulate.kernels import contact_response, rod_elimination, rod_tension
from strandcli.simulate.kernels.rod_scratch import ACCELERATION_SCALE, EDGE, FIRST_SEGMENT, SEGMENT, STIFFNESS, TENSION

LANES = VECTOR // 8
BENDING, SCALE = 0.7, 0.3


@njit(error_model="numpy")
def work_of(address, n, mass, joint, work):
    """Set Σ M a·u of each lane."""
    scratch = vector_pointer_at(np.float64, address)
    rod_elimination.factorise(scratch, n, mass, joint, False, None)
    contact_response.respond(scratch, n, mass)
    store(vector_pointer_at(np.float64, work), 0, contact_response.responded(scratch, n, mass))


@pytest.mark.parametrize("n", [1, 2, 9, 40])
def test_it_solves_the_dense_system(n: int) -> None:
    rng = np.random.default_rng(n)
    scratch = aligned((rod_tension.scratch_size(n), LANES), np.float64)
    scratch[STIFFNESS], scratch[ACCELERATION_SCALE] = BENDING, SCALE
    rows = scratch[FIRST_SEGMENT : FIRST_SEGMENT + n * SEGMENT].reshape(n, SEGMENT, LANES)
    edges = rng.normal(size=(n, 3, LANES))
    rows[:, EDGE : EDGE + 3] = edges / np.linalg.norm(edges, axis=1, keepdims=True)
    rows[:, TENSION] = rng.uniform(0.0, 3.0, (n, LANES))
    pushes = rng.normal(size=(n, 3, LANES))
    for j in range(n):
        place = rod_tension.force_change.py_func(n, j)
        scratch[place : place + 3] = pushes[j]
    mass, joint = rng.uniform(0.5, 2.0, n), rng.uniform(0.5, 2.0, n)
    work = aligned((1, LANES), np.float64)
    work_of(scratch.ctypes.data, n, mass, joint, work.ctypes.data)
    for lane in range(LANES):
        u = dense(rows[:, EDGE : EDGE + 3, lane], rows[:, TENSION, lane], mass, BENDING * joint, pushes[..., lane])
        np.testing.assert_allclose(work[0, lane], (mass[:, None] * pushes[..., lane] * u).sum(), rtol=1e-9)


def dense(
    edges: np.ndarray, tension: np.ndarray, mass: np.ndarray, joint: np.ndarray, pushes: np.ndarray
) -> np.ndarray:
    """(n, 3), the displacements that are least in energy under the pushes among those that keep lengths, to the first
    order."""
    n = len(edges)
    difference = np.eye(n) - np.eye(n, k=-1)
    h = np.diag(mass) + difference.T @ (np.diag(tension) + difference.T @ np.diag(joint) @ difference) @ difference
    lengths = np.zeros((n, 3 * n))
    for j in range(n):
        lengths[j] = np.outer(difference[j], edges[j]).ravel()
    whole = np.block([[np.kron(h, np.eye(3)), lengths.T], [lengths, np.zeros((n, n))]])
    right = np.concatenate([(SCALE * mass[:, None] * pushes).ravel(), np.zeros(n)])
    return np.linalg.solve(whole, right)[: 3 * n].reshape(n, 3)
