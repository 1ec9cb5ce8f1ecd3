"""The diffuse part of a fibre's light, by its closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from strandcli.draw.fibre.kernels.diffuse import kajiya_diffuse
from tests.draw.fibre.test_marschner import DEGREES, direction


def test_diffuse_is_the_sine_to_the_light_over_pi():
    for theta in np.linspace(-90, 90, 19):
        got = kajiya_diffuse(*np.float32([1, 0, 0]), *direction(theta, 33).astype(np.float32))
        assert got == pytest.approx(math.cos(theta * DEGREES) / math.pi, abs=2e-4)


def test_a_mass_of_diffuse_strands_sends_out_no_more_than_falls_in():
    """Facing light and an opaque mass: exitance ∫ L cos dω = π L, which is the irradiance times diffuse · colour."""
    facing = float(kajiya_diffuse(*np.float32([1, 0, 0]), *np.float32([0, 1, 0])))
    assert math.pi * facing == pytest.approx(1, rel=1e-6)
