"""Coulomb's law of a place that a solid touches (`contact.kernels.law`): what iterations come to."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from scratch_kit import LANES, Rows, scratch
from strandcli.simd import load, load3
from strandcli.simulate.contact.kernels import law

Floats = NDArray[np.float64]
NORMAL, ACROSS = np.array([0.6, 0.8, 0.0]), np.array([0.8, -0.6, 0.0])
BOTH = np.array([ACROSS, np.cross(NORMAL, ACROSS)])


@njit(error_model="numpy")
def want(address, friction, late):
    """`law.set_wanted` of one segment, with its gap and that of a second solid where there is one."""
    s = scratch(address, 1)
    contact = (
        load3(s.normal, 0, 1),
        load3(s.across, 0, 1),
        load(s.gap, 0),
        load(s.corner, 0) > 0.0,
        load(s.second_gap, 0),
    )
    law.set_wanted(s, 0, contact, load3(s.slip, 0, 1), friction, late)


class Case(NamedTuple):
    """Places of a ``mobility``, (LANES,), that have slid by ``slip`` (LANES, 2) along both tangents and are ``gap``
    (LANES,) away before any force."""

    mobility: Floats
    gap: Floats
    slip: Floats


def case() -> Case:
    rng = np.random.default_rng(4)
    gap = -rng.uniform(0.1, 1.0, LANES)
    return Case(rng.uniform(0.2, 3.0, LANES), gap, rng.normal(size=(LANES, 2)) * 10 ** rng.uniform(-2, 1, (LANES, 1)))


def rows_of(one: Case) -> Rows:
    rows = Rows(1)
    rows.normal[0], rows.across[0] = NORMAL[:, None], ACROSS[:, None]
    rows.mobility[0], rows.gap[0, 0], rows.second_gap[0] = one.mobility, one.gap, 1.0
    rows.slip[0] = (one.slip @ BOTH).T
    return rows


def settled(one: Case, friction: float, late: bool = False) -> tuple[Floats, Floats, Floats]:
    """Pressure (LANES,), friction and slip (LANES, 2) where iterations by the law's equations end."""
    rows, m = rows_of(one), one.mobility
    for _ in range(200):
        want(rows.address, friction, late)
        gap, along = rows.wanted[0, 0], rows.wanted[0, 1:]
        give = rows.compliance[0]
        change = np.array([-gap / m, *(-along / (m + give))])
        rows.force[0] += np.array([NORMAL, *BOTH]).T @ change
        rows.gap[0, 0] += m * change[0]
        rows.slip[0] += BOTH.T @ (m * change[1:])
    force = rows.force[0].T
    return force @ NORMAL, force @ BOTH.T, rows.slip[0].T @ BOTH.T


@pytest.mark.parametrize("late", [False, True])
@pytest.mark.parametrize("friction", [0.1, 0.5, 2.0])
def test_iterations_come_to_coulombs_law(friction: float, late: bool) -> None:
    """Places that can be held stick; the others slide against a force of µ times the pressure."""
    one = case()
    pressure, drag, slip = settled(one, friction, late)
    np.testing.assert_allclose(pressure, -one.gap / one.mobility, rtol=1e-9)
    needed = np.linalg.norm(one.slip, axis=1) / one.mobility
    sticks = needed <= friction * pressure
    assert sticks.any() or friction < 0.5
    assert not sticks.all()
    np.testing.assert_allclose(slip[sticks], 0, atol=1e-9)
    np.testing.assert_allclose(drag[sticks], -one.slip[sticks] / one.mobility[sticks, None], atol=1e-9)
    size = np.linalg.norm(slip, axis=1, keepdims=True)
    opposed = -friction * pressure[:, None] * slip / np.maximum(size, 1e-30)
    np.testing.assert_allclose(drag[~sticks], opposed[~sticks], rtol=1e-6)
    np.testing.assert_allclose(slip - one.slip, one.mobility[:, None] * drag, atol=1e-9)


def test_without_friction_nothing_is_held() -> None:
    one = case()
    pressure, drag, slip = settled(one, 0.0)
    np.testing.assert_allclose(pressure, -one.gap / one.mobility, rtol=1e-9)
    assert np.abs(drag).max() < 1e-4 * np.abs(one.slip).max()
    np.testing.assert_allclose(slip, one.slip, rtol=1e-4)


def test_in_a_corner_the_second_gap_takes_the_place_of_slip() -> None:
    """Along the groove friction is µ times what both solids press with."""
    one = case()
    rows = rows_of(one)
    rows.corner[...], rows.second_gap[...] = 1.0, -0.3
    rows.force[0] = 2 * NORMAL[:, None] + 1.5 * ACROSS[:, None]
    want(rows.address, 0.4, False)
    np.testing.assert_allclose(rows.wanted[0, :2], [one.gap, np.full(LANES, -0.3)])
    np.testing.assert_array_equal(rows.compliance[0, 0], 0)
    cone, there = 0.4 * (2 + 1.5), np.abs(one.slip[:, 1])
    np.testing.assert_allclose(rows.compliance[0, 1], np.maximum(there - one.mobility * cone, 0) / cone)
    np.testing.assert_allclose(rows.wanted[0, 2], one.slip[:, 1])


def test_late_compliance_and_mobility_change_by_a_geometric_mean() -> None:
    one = case()
    rows = rows_of(one)
    rows.force[0] = NORMAL[:, None]
    want(rows.address, 0.3, False)
    wanted = rows.compliance.copy()
    rows.compliance[...] = 1.0
    want(rows.address, 0.3, True)
    mean = np.sqrt((wanted[0, 1] + one.mobility) * (1.0 + one.mobility))
    np.testing.assert_allclose(rows.compliance[0, 1] + one.mobility, mean)
