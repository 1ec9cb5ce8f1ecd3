"""A slice of `make kills`."""

from __future__ import annotations

from pathlib import Path

from kills import kills, terms


def test_killed_renders_lose_nothing(tmp_path: Path) -> None:
    for found in kills(range(4), tmp_path):
        assert found["frames that differ"] == found["frames missing"] == found["left behind"] == 0


def test_sigterm_ends_in_good_order(tmp_path: Path) -> None:
    (found,) = terms(range(1), tmp_path)
    assert found["done"] == 1, found
    assert found["temporary files"] == 0
