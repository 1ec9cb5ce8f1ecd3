"""Damaged files of strands and of meshes are read or refused in one line: a slice of `make fuzz`."""

from __future__ import annotations

import pytest

import fuzz

COUNT = 300


@pytest.mark.parametrize("suffix", fuzz.seeds())
def test_damaged_files_are_read_or_refused(suffix: str) -> None:
    wrong: list[str] = []
    found = fuzz.fuzz(suffix, range(COUNT), wrong.append)
    assert wrong == []
    assert found["refused"] > 0.3 * COUNT
    assert found["read"] > 0
