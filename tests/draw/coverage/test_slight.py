"""Fragments behind what hides nearly all of them, which take light from one vertex alone."""

from __future__ import annotations

import numpy as np
import pytest

from strandcli.draw.common.scratch import Scratch
from strandcli.draw.coverage import coverage
from strandcli.draw.coverage.coverage import SLIGHT, Coverage
from strandcli.draw.geometry.curves import Polylines

SIZE = (48, 40)
VERTICES = 8
"""Of a strand: the last has an odd rank."""
OPACITY = 0.8
VEILS, NEAR = 2, 0.95
THROUGH = (1 - OPACITY) ** VEILS
assert float(SLIGHT) > THROUGH


def strands(count: int) -> np.ndarray:
    """(count, VERTICES, 3) of x, y and depth number: at random."""
    rng = np.random.default_rng(3)
    across = np.linspace(2, 44, VERTICES) + np.zeros((count, 1))
    down = rng.uniform(2, 38, (count, 1)) + rng.normal(0, 3, (count, VERTICES)).cumsum(1)
    return np.stack([across, down, rng.uniform(0.2, 0.9, (count, 1)) + 0 * across], 2).astype(np.float32)


def drawn(
    lines: np.ndarray, width: float, colours: np.ndarray, room: int = 400_000, veiled: bool = True
) -> tuple[np.ndarray, np.ndarray, int]:
    """The picture of strands of one width on black, perhaps behind a black veil that lets through `THROUGH` of their
    light, over that; the vertices that were lit, and the number of layers."""
    if veiled:
        veil = np.stack([np.linspace(-100, 200, VERTICES), np.full(VERTICES, 20.0), np.full(VERTICES, NEAR)], 1)
        lines = np.concatenate([np.repeat(veil[None], VEILS, 0), lines]).astype(np.float32)
        lines[:VEILS, :, 2] += np.arange(VEILS, dtype=np.float32)[:, None] * 0.01
        colours = np.concatenate([np.zeros((VEILS * VERTICES, 3), np.float32), colours])
    screen = np.ascontiguousarray(lines.reshape(-1, 3))
    first = np.arange(0, len(screen) + 1, lines.shape[1])
    widths = np.full(len(screen), width / OPACITY, np.float32)
    widths[: VEILS * VERTICES * veiled] = 300
    image, lit, layers = np.zeros((*SIZE[::-1], 3), np.float32), np.zeros(len(screen), bool), 0
    for layer in Coverage(SIZE, OPACITY, room).layers(Polylines(first, screen), screen, widths, None, 1, Scratch()):
        lit |= layer.marks != 0
        seen = np.where(lit[:, None], colours, np.nan).astype(np.float32)
        layer.blend(seen, image)
        layers += 1
    if veiled:
        image, lit = image / THROUGH, lit[VEILS * VERTICES :]
    return image, lit.reshape(-1, VERTICES), layers


def test_strands_of_little_weight_are_lit_at_every_second_vertex(monkeypatch: pytest.MonkeyPatch) -> None:
    lines = strands(40)
    white = np.ones((lines.size // 3, 3), np.float32)
    thin, lit, _ = drawn(lines, 0.006, white)
    assert lit[:, ::2].mean() > 0.95
    assert not lit[:, 1::2].any()
    assert np.isfinite(thin).all()
    assert drawn(lines, 0.006, white, veiled=False)[1].mean() > 0.95  # however thin they are; some leave the picture
    monkeypatch.setattr(coverage, "SLIGHT", np.float32(0))
    exact, all_lit, _ = drawn(lines, 0.006, white)
    assert all_lit.mean() > 0.95
    np.testing.assert_allclose(thin, exact, atol=1e-6)


def test_light_is_that_of_the_nearer_even_vertex(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where it rises along strands, it is right in the mean; nowhere is it farther off than one vertex."""
    lines = strands(30)
    rise = np.tile(np.arange(VERTICES, dtype=np.float32)[:, None], (len(lines), 3))
    thin, _, _ = drawn(lines, 0.002, rise)
    cover, _, _ = drawn(lines, 0.002, np.ones_like(rise))
    monkeypatch.setattr(coverage, "SLIGHT", np.float32(0))
    exact, _, _ = drawn(lines, 0.002, rise)
    off = (thin - exact)[cover > 0] / cover[cover > 0]
    assert 0.9 < np.abs(off).max() <= 1.001
    inner = slice(8, 32)  # as much before even vertices as after them
    assert abs((thin - exact)[:, inner].sum() / cover[:, inner].sum()) < 0.05
