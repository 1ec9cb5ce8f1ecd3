"""Strands do not pass through each other, however thin they are, however fast, and however they slide."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from crossing_kit import crosses, crossings, solver_of, strands
from strandcli.simulate.contact.kernels import contact_approach
from strandcli.simulate.contact.kernels.contact_columns import COUNTS, GAP, NORMAL, NUMBERS, VECTORS, WANTED
from strandcli.simulate.rod.kernels.arrays import PACK

Floats = NDArray[np.float64]


@pytest.mark.parametrize("thickness", [0.0002, 0.001, 0.005])
@pytest.mark.parametrize("speed", [3, 8, 200])
def test_thin_strands_that_fall_across_each_other_do_not_pass(
    speed: float, thickness: float, steps: list[tuple[Floats, Floats]]
) -> None:
    """One turns about its root onto the other, and slides along it, at three angles."""
    for angle in np.radians([90, 45, 10]):
        x, z = np.cos(angle), np.sin(angle)
        groom = strands([[-0.5, 0, 0], [-0.5 * x, 0.3, -0.5 * z]], [[1, 0, 0], [x, 0, z]], [1, 1])
        text = (
            "rod: {rest: straight, radius: 1.0e-3, young: 1.0e+9, drag: 0, damping: 0}\n"
            f"time: {{fps: 24}}\nemitter: {{strands: 2, particles: 11, length: 1}}\n"
            f"rules: [gravity: {{acceleration: [0, 0, 0]}}, contact: {{thickness: {thickness}}}]\n"
        )
        solver = solver_of(text, groom)
        for one in (solver.state.velocity, solver.state.before, solver.state.ahead):
            rows = one.reshape(1, -1, 3, PACK)
            rows[0, :, 1, 1] = -speed * np.linspace(0, 1, rows.shape[1])
        solver.advance(14 + int(30 / speed))
    assert sum(crossings(*one) for one in steps) == 0


def test_segments_that_pass_through_each_other_are_kept_on_their_sides() -> None:
    """Of two segments on straight ways at random, fast and slow, for a thickness of a thousandth of their length: those
    that pass through each other have a contact that they are too close for at the end."""
    rng = np.random.default_rng(3)
    count, pair = 0, np.array([[0, 0, 1, 0]])
    for _ in range(3000):
        start = rng.normal(size=(2, 1, 3)) * 0.3 + np.cumsum(rng.normal(size=(2, 2, 3)), 1)
        end = start + rng.normal(size=(2, 2, 3)) * 10 ** rng.uniform(-1, 1)
        if crosses(start[0], end[0], start[1], end[1]):
            count += 1
            numbers, vectors = looked_at(start, end, pair)
            assert numbers[COUNTS] == 1
            assert numbers[GAP] < numbers[WANTED]
            assert np.linalg.norm(vectors[NORMAL : NORMAL + 3]) == pytest.approx(1)
    assert count > 80


def looked_at(start: Floats, end: Floats, pair: NDArray[np.int64]) -> tuple[Any, Any]:
    numbers, vectors = np.zeros((1, NUMBERS)), np.zeros((1, VECTORS))
    contact_approach.look(start, end, np.ones(2), pair, (1e-3, 0.2, 1.05e-3), numbers, vectors, np.zeros((6, 2, 3)))
    return numbers[0], vectors[0]
