"""Friction of contacts between strands that slide: the solution for one contact, and strands laid on a slope."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray

from strandcli.simulate.contact.kernels import contact_solve
from strandcli.simulate.contact.kernels.contact_columns import NORMAL, START, VECTORS
from strandcli.study.references import incline
from strandcli.study.references.experiment import track_of

Floats = NDArray[np.float64]


@njit(error_model="numpy")
def force_of(vector: Floats, wanted: float, friction: float, w: Floats, rows: Floats) -> None:
    contact_solve.force_of(vector, wanted, friction, w, rows)


def response(rng: np.random.Generator, along: float) -> Floats:
    """(3, 3) of strands that give way ``along`` themselves by so much, as a share of across."""
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    found: Floats = (axes * [1.0, 0.7, along]) @ axes.T
    return found


@pytest.mark.parametrize("friction", [0.0, 0.1, 0.5, 1.0, 3.0, 100.0])
@pytest.mark.parametrize("along", [1.0, 0.04, 1e-4])
def test_what_slides_obeys_coulombs_law(along: float, friction: float) -> None:
    """Both stay apart, friction is µ times the pressure, and opposes the way. Iterations for its direction leave it
    across the way where strands hardly give way along themselves."""
    rng = np.random.default_rng(1)
    slid = 0
    for _ in range(300):
        n = rng.normal(size=3)
        vector, rows = np.zeros(VECTORS), np.zeros((7, 3))
        vector[NORMAL : NORMAL + 3] = n = n / np.linalg.norm(n)
        vector[START : START + 3] = n
        way = rng.normal(size=3)
        rows[0] = (1 - rng.uniform(0.0, 1.0)) * n + way - (way @ n) * n
        w = response(rng, along)
        force_of(vector, 1.0, friction, w, rows)
        push, free = rows[1] @ n, rows[0]
        drag = rows[1] - push * n
        left = free - n + w @ rows[1]
        assert left @ n == pytest.approx(0, abs=1e-6)
        assert push >= 0
        size = np.linalg.norm(drag)
        assert size <= friction * push * (1 + 1e-6) + 1e-12
        if np.linalg.norm(left) > 1e-6:
            slid += 1
            assert size == pytest.approx(friction * push, rel=1e-6)
            assert drag @ left == pytest.approx(-size * np.linalg.norm(left), rel=1e-6, abs=1e-9)
    assert slid > 0 or friction > 3


def ways_on_slopes(friction: float, rate: float, monkeypatch: pytest.MonkeyPatch) -> Floats:
    """(slopes,) metres that tips go within a second of strands laid across others, in the order of `incline.OFF`."""
    monkeypatch.setattr(incline, "MU", friction)
    track = track_of(incline.case(11), 1 / rate, 1.0, moving=True)
    tips = track.positions[:, :: 1 + len(incline.RAILS), -1]
    found: Floats = np.linalg.norm(tips - tips[0], axis=-1).max(0)
    return found


@pytest.mark.parametrize("rate", [24, 240])
@pytest.mark.parametrize("friction", [0.4, 1.0, 1.5])
def test_strands_stick_at_once_to_slopes_that_are_flat_enough(
    friction: float, rate: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where friction did not oppose the way, tips slid by 7 to 26 mm at first."""
    ways = ways_on_slopes(friction, rate, monkeypatch)
    off = np.array(incline.OFF)
    assert ways[off < -1].max() < 2.5e-4
    assert ways[off < 0].max() < 6e-4
    assert ways[off > 0].min() > 5e-3
