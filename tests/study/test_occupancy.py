"""The foil of occupancy maps: exact where its assumptions hold, off where they do not, on the very same fragments."""

from __future__ import annotations

import numpy as np
import pytest

from strandcli.study.kernels import occupancy as kernel

COUNT, PIXELS = 40, 5
NONE = np.zeros((0, 3), np.float32)


def lists(seed: int, even: bool) -> tuple[np.ndarray, ...]:
    """Fragments of some pixels, each a strand of its own, in the order in which strands are drawn: ``even`` in depth
    and opacity, or not."""
    rng = np.random.default_rng(seed)
    begin = np.arange(PIXELS + 1) * COUNT
    total = PIXELS * COUNT
    place = 2 * np.tile(np.arange(COUNT), PIXELS)
    steps = np.concatenate([rng.permutation(COUNT) for _ in range(PIXELS)])
    depth = -1 + steps / COUNT if even else -rng.uniform(0.1, 1, total) ** 3
    alpha = np.full(total, 0.05) if even else rng.uniform(0.01, 0.4, total)
    vertex = rng.uniform(0, 1, (2 * COUNT, 3)).astype(np.float32)
    return begin, place, alpha.astype(np.float32), np.zeros(total, np.float32), depth.astype(np.float32), vertex


def laid(seed: int, even: bool, slices: int = 0, slabs: int = 4) -> np.ndarray:
    begin, place, alpha, along, depth, vertex = lists(seed, even)
    image = np.full((PIXELS, 3), 0.25, np.float32)
    if slices:
        kernel.by_occupancy(begin, place, alpha, along, depth, slices, slabs, 1, vertex, NONE, image)
    else:
        kernel.in_order(begin, place, alpha, along, depth, 1, vertex, NONE, image)
    return image


def test_in_order_is_front_to_back() -> None:
    begin, place, alpha, _, depth, vertex = lists(1, False)
    image = laid(1, False)
    for p in range(PIXELS):
        own = slice(begin[p], begin[p + 1])
        through, light = 1.0, np.zeros(3)
        for f in begin[p] + np.argsort(depth[own], kind="stable"):
            light += through * alpha[f] * vertex[place[f]]
            through *= 1 - alpha[f]
        np.testing.assert_allclose(image[p], light + 0.25 * through, atol=1e-6)


def test_one_strand_a_slice_all_as_opaque_are_in_order() -> None:
    np.testing.assert_allclose(laid(2, True, 128), laid(2, True), atol=1e-5)


def test_otherwise_fewer_slices_are_worse_and_the_background_stays_exact() -> None:
    apart = [np.abs(laid(3, False, slices) - laid(3, False)).mean() for slices in (4, 128)]
    assert apart[0] > apart[1] > 1e-3
    begin, place, alpha, along, depth, vertex = lists(3, False)
    image = np.ones((PIXELS, 3), np.float32)
    kernel.by_occupancy(begin, place, alpha, along, depth, 128, 4, 1, 0 * vertex, NONE, image)
    np.testing.assert_allclose(image[:, 0], np.prod(1 - alpha.reshape(PIXELS, -1), 1), rtol=1e-5)


def test_opacities_are_found_again_from_sorted_weights() -> None:
    begin, place, alpha, along, depth, _ = lists(4, False)
    screen = np.zeros((2 * COUNT, 3), np.float32)
    screen[place[:COUNT], 2] = -depth[:COUNT]
    order = np.argsort(depth[:COUNT])
    weight = alpha[order] * np.concatenate([[1], np.cumprod(1 - alpha[order])[:-1]])
    found, deep, places = np.empty(COUNT, np.float32), np.empty(COUNT, np.float32), place[:COUNT][order].copy()
    kernel.undo(begin[:2], places, weight.astype(np.float32), along[:COUNT].copy(), 1, screen, found, deep)
    assert (np.diff(places) > 0).all()
    assert found == pytest.approx(alpha[:COUNT], rel=2e-3)
    np.testing.assert_array_equal(deep, depth[:COUNT])
