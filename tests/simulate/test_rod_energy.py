"""The energy that a step minimises, by which it tells merit, against NumPy's."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

from strandcli.blocks import aligned
from strandcli.constants import VECTOR
from strandcli.simd import broadcast, store, vector_pointer
from strandcli.simulate.kernels import rod
from strandcli.simulate.kernels.rod_scratch import (
    EDGE,
    FIRST_SEGMENT,
    INERTIAL,
    REST_BEND,
    SEGMENT,
    STIFFNESS,
    vectors_for,
)

N = 5
LANES = VECTOR // 8


@njit(error_model="numpy")
def energies(scratch: Any, mass: Any, joint: Any, out: Any) -> None:
    """Store twice the energy of scratch."""
    s = vector_pointer(scratch)
    none = broadcast(s, 0.0) > 1.0
    store(vector_pointer(out), 0, rod.retract(s, N, mass, joint, False, none))


def test_it_is_that_of_all_particles_and_joints() -> None:
    draw = np.random.Generator(np.random.Philox(key=5))
    scratch, out = aligned((vectors_for(N), LANES), np.float64), aligned((LANES,), np.float64)
    scratch[...] = draw.normal(size=scratch.shape)
    mass, joint = draw.uniform(1, 2, N), draw.uniform(1, 2, N)
    segments = [scratch[FIRST_SEGMENT + j * SEGMENT :] for j in range(-1, N)]
    scratch[STIFFNESS] = 3.0
    energies(scratch.reshape(-1), mass, joint, out)
    goal = np.zeros(LANES)
    for j in range(1, N + 1):
        bend = segments[j][EDGE : EDGE + 3] - segments[j - 1][EDGE : EDGE + 3] - segments[j][REST_BEND : REST_BEND + 3]
        goal += 3.0 * joint[j - 1] * (bend**2).sum(0) + mass[j - 1] * (segments[j][INERTIAL : INERTIAL + 3] ** 2).sum(0)
    np.testing.assert_allclose(out, goal, rtol=1e-12)
