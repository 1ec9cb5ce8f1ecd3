"""Damaged files of all that strandcli reads are read or refused in one line: a slice of `make fuzz`."""

from __future__ import annotations

import pytest

import fuzz

COUNT, FEWER = 300, 60


@pytest.mark.parametrize("suffix", fuzz.seeds())
def test_damaged_files_are_read_or_refused(suffix: str) -> None:
    wrong: list[str] = []
    found = fuzz.fuzz(suffix, range(COUNT), wrong.append)
    assert wrong == []
    assert found["refused"] > 0.3 * COUNT
    assert found["read"] > 0


@pytest.mark.parametrize("kind", fuzz.KINDS)
def test_damaged_presets_pictures_and_files_of_earlier_runs_are_read_or_refused(kind: str) -> None:
    wrong: list[str] = []
    found = fuzz.fuzz(kind, range(FEWER), wrong.append)
    assert wrong == []
    assert found["refused"] > 0.1 * FEWER
