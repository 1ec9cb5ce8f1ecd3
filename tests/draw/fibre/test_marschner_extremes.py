"""Marschner's fibre for whatever it is given: finite, and the same compiled and as plain Python."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from strandcli.draw.fibre import marschner as tables_of
from strandcli.draw.fibre.kernels import marschner as kernel
from strandcli.draw.fibre.kernels.diffuse import kajiya_diffuse
from strandcli.scene.model import Material
from tests.draw.fibre.test_marschner import direction, evaluate

ZERO = np.float32(0)


NUMBERS = st.floats(width=32, allow_nan=True, allow_infinity=True)
UNITS = st.sampled_from([0.0, 1.0, -1.0, 1.0000002, 0.70710677, 1e-20, 1e-7])
ROUGH = tables_of.build_tables(Material(colour_variation=0.2))
SHARP = tables_of.build_tables(Material(beta=0.1, azimuthal=1.0, colour_variation=0.2))


@settings(max_examples=100, deadline=None)
@given(st.lists(NUMBERS | UNITS, min_size=12, max_size=12), st.sampled_from([ROUGH, SHARP]))
def test_finite_and_not_negative_whatever_is_passed(numbers, tables):
    arguments = [np.float32(x) for x in numbers]
    with np.errstate(all="ignore"):
        ways = [tuple(arguments[i : i + 3]) for i in (0, 3, 6)]
        result = kernel.marschner(*ways, tables.arrays, tuple(arguments[9:]))
        plain = kernel.marschner(*ways, replace(tables, paths=None).arrays, (ZERO, ZERO, ZERO))
        diffuse = kajiya_diffuse(*arguments[:6])
    assert np.isfinite([*result, *plain, diffuse]).all()
    assert min(*result, *plain, diffuse) >= 0


@pytest.mark.parametrize("tables", [ROUGH, SHARP])
def test_degenerate_directions(tables):
    """Light or eye along the strand, both, opposite, and a hair's breadth from it."""
    near = direction([90, -90, 89.99, -89.99, 89.9, 60, 0], 0)
    lights, views = np.repeat(near, len(near), 0), np.tile(near, (len(near), 1))
    result = evaluate(tables, lights, views)
    assert np.isfinite(result).all()
    assert (result >= 0).all()
    assert (result < 1e4).all()
    along_the_strand = np.abs(lights[:, 0]) == 1
    assert (result[along_the_strand] == 0).all()
