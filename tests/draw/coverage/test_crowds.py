"""Crowds of strands: what cannot be seen is left out early, and no pixel shows it."""

from __future__ import annotations

import numpy as np

from strandcli.draw.common.scratch import Scratch
from strandcli.draw.coverage.coverage import Coverage
from strandcli.draw.geometry.curves import Polylines

WIDTH, HEIGHT = 32, 24


def crowd(seed: int, count: int, low: float, high: float, wide: float) -> tuple[np.ndarray, np.ndarray]:
    """Strands (count, 2, 3) across the picture, with depth numbers from low to high, and their widths (count, 2)."""
    rng = np.random.default_rng(seed)
    ends = np.zeros((count, 2, 3))
    ends[:, :, 0] = [-1, WIDTH + 1]
    ends[:, :, 1] = rng.uniform(-4, HEIGHT + 4, (count, 1)) + rng.uniform(-3, 3, (count, 2))
    ends[:, :, 2] = rng.uniform(low, high, (count, 1))
    return ends, np.full((count, 2), wide)


def drawn(
    ends: np.ndarray, wide: np.ndarray, light: np.ndarray, workers: int = 1, opacity: float = 1.0
) -> tuple[np.ndarray, int]:
    """The picture of strands of these lights, (count, 3), and the number of fragments found."""
    screen = ends.reshape(-1, 3).astype(np.float32)
    image = np.full((HEIGHT, WIDTH, 3), 9, np.float32)
    coverage = Coverage((WIDTH, HEIGHT), opacity)
    first = np.arange(0, len(screen) + 1, 2)
    widths = wide.reshape(-1).astype(np.float32)
    for layer in coverage.layers(Polylines(first, screen), screen, widths, None, workers, Scratch()):
        layer.blend(np.repeat(light, 2, 0).astype(np.float32), image)
    return image, coverage.fragments


def test_what_stands_behind_a_crowd_changes_nothing_and_is_not_listed() -> None:
    """Thousands of strands behind some that let no light through, whether they come before or after these, and in the
    middle of the picture alone, where other pixels show what is behind."""
    rng = np.random.default_rng(1)
    front, wide = crowd(2, 1500, 0.5, 0.6, 0.3)
    light = rng.uniform(0, 1, (len(front), 3))
    alone, few = drawn(front, wide, light)
    assert alone.max() < 1.01  # nothing shows the background
    back, back_wide = crowd(3, 9000, 0.1, 0.49, 0.3)
    black = np.zeros((len(back), 3))
    for turn in (1, -1):
        ends, widths, lights = (
            np.concatenate(both[::turn]) for both in ((front, back), (wide, back_wide), (light, black))
        )
        for workers in (1, 3):
            image, found = drawn(ends, widths, lights, workers)
            np.testing.assert_array_equal(image, alone)
            assert found < 1.5 * few, "of the strands behind, six times as many, few are listed"
    narrow = front.copy()
    narrow[:, 1, 0] = WIDTH / 2
    ends, widths, lights = (
        np.concatenate([back, narrow]),
        np.concatenate([back_wide, wide]),
        np.concatenate([black, light]),
    )
    image, _ = drawn(ends, widths, lights)
    behind, _ = drawn(back, back_wide, black)
    np.testing.assert_array_equal(image[:, WIDTH // 2 + 1 :], behind[:, WIDTH // 2 + 1 :])


def test_transparent_strands_that_hide_others_together_leave_these_out_while_they_are_found() -> None:
    """Wide strands that let two fifths through, before others, in a tile of fewer rows than are ordered."""
    front, wide = crowd(6, 220, 0.5, 0.6, 3.0)
    back, back_wide = crowd(7, 150, 0.1, 0.4, 3.0)
    light = np.random.default_rng(8).uniform(0, 1, (len(front), 3))
    alone, few = drawn(front, wide, light, opacity=0.6)
    both = np.concatenate([front, back]), np.concatenate([wide, back_wide]), np.concatenate([light, 0 * light[:150]])
    image, found = drawn(*both, opacity=0.6)
    np.testing.assert_array_equal(image, alone)
    assert found < 1.05 * few


def test_a_crowd_of_faint_strands_is_seen_to_its_end() -> None:
    """A thousand strands behind each other let half of the light through: all of them count."""
    ends, wide = crowd(4, 3000, 0.2, 0.9, 0.003)
    both, found = drawn(ends, wide, np.zeros((len(ends), 3)))
    assert found > 2000 * WIDTH  # those that cross the picture
    front, back = ends[ends[:, 0, 2] > 0.5], ends[ends[:, 0, 2] <= 0.5]
    one = drawn(front, wide[: len(front)], np.zeros((len(front), 3)))[0].astype(np.float64) / 9
    two = drawn(back, wide[: len(back)], np.zeros((len(back), 3)))[0].astype(np.float64) / 9
    np.testing.assert_allclose(both / 9, one * two, rtol=2e-4)
