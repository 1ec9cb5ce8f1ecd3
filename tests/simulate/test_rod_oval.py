"""Rests of oval sections by the bends of a step's first solution (`kernels.rod_oval`)."""

from __future__ import annotations

import numpy as np
from numba import njit

from strandcli.blocks import aligned
from strandcli.constants import VECTOR
from strandcli.simd import vector_pointer_at
from strandcli.simulate.kernels import rod_oval, rod_tension
from strandcli.simulate.kernels.records import DAMPING, NUMBERS, ROUNDING, SOFT, STEP
from strandcli.simulate.kernels.rod_scratch import EDGE, FIRST_SEGMENT, REST_BEND, SEGMENT, STIFFNESS

LANES = VECTOR // 8


@njit(error_model="numpy")
def correct(address, n, numbers):
    """Correct the rests of oval sections."""
    rod_oval.correct(vector_pointer_at(np.float64, address), n, np.ones(n), numbers)


def test_a_first_solution_far_off_says_no_more_of_oval_rests_than_its_directions() -> None:
    """An edge that is a million times too long would bend the rest by as much."""
    n, numbers = 3, np.zeros(NUMBERS)
    numbers[[SOFT, STEP, DAMPING, ROUNDING]] = 0.5, 1.0, 0.0, 1e-15
    scratch = aligned((rod_tension.scratch_size(n), LANES), np.float64)
    rows = scratch[FIRST_SEGMENT : FIRST_SEGMENT + n * SEGMENT].reshape(n, SEGMENT, LANES)
    scratch[STIFFNESS] = 1.0
    scratch[FIRST_SEGMENT - SEGMENT + EDGE] = 1.0
    rows[:, EDGE] = 1.0
    rows[1, EDGE + 1] = 1e6
    for j in range(n):  # the thin axes
        scratch[FIRST_SEGMENT + (n + 2) * SEGMENT + j * rod_tension.GAIN + 1] = 1.0
    correct(scratch.ctypes.data, n, numbers)
    bends = rows[:, REST_BEND + 1, 0]
    np.testing.assert_allclose(bends, [0.0, 0.5, -0.5], atol=1e-5)
