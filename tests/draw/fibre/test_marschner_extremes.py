"""Marschner's fibre for whatever it is given: finite, and the same compiled and as plain Python."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from strandcli.draw.fibre import marschner as tables_of
from strandcli.draw.fibre.kernels import marschner as kernel
from strandcli.draw.fibre.kernels.diffuse import kajiya_diffuse
from strandcli.draw.fibre.pigment import absorption
from strandcli.scene.model import Material
from tests.draw.fibre.test_marschner import direction, evaluate

ZERO = np.float32(0)


def test_colours_at_and_beyond_the_ends_stay_finite():
    sigma = absorption([0.0, -1.0, 1e-9, 0.5, 1.0, 3.0], 0.3)
    assert np.isfinite(sigma).all()
    assert sigma[0] == sigma[1] == sigma[2] > sigma[3] > sigma[4] == sigma[5] == 0
    for colour in ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (5.0, 0.0, 1.0)):
        tables = tables_of.build_tables(Material(colour=colour, colour_variation=0.5))
        assert np.isfinite(tables.nodes).all()
        assert np.isfinite(tables.paths).all()
        assert (tables.nodes >= 0).all()


NUMBERS = st.floats(width=32, allow_nan=True, allow_infinity=True)
UNITS = st.sampled_from([0.0, 1.0, -1.0, 1.0000002, 0.70710677, 1e-20, 1e-7])
ROUGH = tables_of.build_tables(Material(colour_variation=0.2))
SHARP = tables_of.build_tables(Material(beta=0.1, azimuthal=1.0, colour_variation=0.2))


@settings(max_examples=400, deadline=None)
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


PROGRAM = """
import numpy as np
from strandcli.draw.fibre.kernels.marschner import marschner
from strandcli.draw.fibre.marschner import build_tables
from strandcli.scene.model import Material
tables = build_tables(Material(colour_variation=0.2))
for row in np.random.default_rng(9).normal(size=(50, 3, 3)).astype(np.float32):
    row /= np.linalg.norm(row, axis=1, keepdims=True)
    extra = tuple(np.float32([0.1, -0.02, 0.3]))
    result = marschner(*map(tuple, row), tables.arrays, extra)
    print(*(np.float32(x).tobytes().hex() for x in result))
"""


def test_compiled_and_plain_python_agree_to_the_bit():
    """A process without a compiler runs the same operations one by one in float32."""
    said = []
    for disabled in ("0", "1"):
        environment = {**os.environ, "NUMBA_DISABLE_JIT": disabled}
        run = subprocess.run(
            [sys.executable, "-c", PROGRAM], env=environment, capture_output=True, text=True, check=True
        )
        said.append(run.stdout.split())
    assert len(said[0]) == 150
    assert said[0] == said[1]
