"""Damaged files of all that strandcli reads are read or refused in one line: a slice of `make fuzz`."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest

import fuzz
from fuzz_guard import guarded

COUNT, FEWER = 100, 30


@pytest.mark.parametrize("suffix", fuzz.seeds())
def test_damaged_files_are_read_or_refused(suffix: str) -> None:
    wrong: list[str] = []
    found = fuzz.fuzz(suffix, range(COUNT), wrong.append)
    assert wrong == []
    assert found["refused"] > 0.3 * COUNT
    assert found["read"] > 0


@pytest.mark.parametrize("kind", fuzz.KINDS)
def test_damaged_presets_and_files_of_earlier_runs_are_read_or_refused(kind: str) -> None:
    wrong: list[str] = []
    found = fuzz.fuzz(kind, range(FEWER), wrong.append)
    assert wrong == []
    assert found["refused"] > 0.1 * FEWER


def test_files_elsewhere_and_pickles_are_noticed(tmp_path: Path) -> None:
    inside, outside = tmp_path / "in", tmp_path / "out"
    inside.mkdir()
    outside.mkdir()
    with guarded(inside) as done:
        (inside / "a").write_text("a")
        (inside / "a").rename(inside / "b")
        (inside / "b").read_text()
    assert done == []
    with guarded(inside) as done:
        (inside / ".." / "out" / "a").write_text("a")
        (inside / "b").rename(outside / "b")
        pickle.loads(pickle.dumps(Path))
    assert [line.split()[0] for line in done] == [f"{inside}/../out/a", "os.rename", "pickle.find_class"]
