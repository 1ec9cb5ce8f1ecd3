"""Strands that move, written and read, and `convert` of them: every moment is written, and edits follow it."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import exchange_kit as kit
from abc_kit import Tree
from cli_runs import Runner
from strandcli.exchange.files import read, write
from strandcli.exchange.formats import usd
from strandcli.exchange.strands import Strands, TimeSample

FRAMES, FPS = 5, 24


def moving() -> tuple[Strands, list[TimeSample]]:
    """Strands of other lengths, two of them the same, at several moments."""
    generator = np.random.default_rng(2)
    lists = [generator.normal(size=(count, 3)).astype(np.float32) for count in (3, 9, 4, 12, 30)]
    held = kit.of([*lists, lists[1]])
    ways = generator.normal(size=(FRAMES, *held.points.shape)).astype(np.float32)
    ways[0] = 0
    return held, [TimeSample(i / FPS, held.points + ways[i]) for i in range(FRAMES)]


@pytest.mark.parametrize("suffix", [".abc", *usd.suffixes])
@settings(max_examples=15, deadline=None)
@given(strands=kit.lists_of_strands, frames=st.integers(1, 4), fps=st.sampled_from([1.0, 23.976, 24.0, 60.0]))
def test_points_at_several_times_are_read_again(
    suffix: str, strands: list[kit.Strand], frames: int, fps: float
) -> None:
    held = kit.of(strands)
    held = replace(held, attributes=kit.attributes(held.count, held.points.shape[0]))
    told = [TimeSample((7 + i) / fps, held.points + np.float32(i)) for i in range(frames)]
    with tempfile.TemporaryDirectory() as folder:
        path, again = Path(folder, f"a{suffix}"), Path(folder, f"b{suffix}")
        assert write(path, held, iter(told)) == []
        assert [one.name for one in Path(folder).iterdir()] == [path.name]
        found = read(path)
        assert found.points.tobytes() == told[0].points.tobytes()
        assert found.first.tolist() == held.first.tolist()
        assert found.attributes.keys() == held.attributes.keys()
        for name, one in found.attributes.items():
            other = held.attributes[name]
            assert (name, one.domain, one.values.dtype) == (name, other.domain, other.values.dtype)
            assert one.values.shape == other.values.shape
            assert one.values.tobytes() == other.values.tobytes()
        seen = kit.moments(path)
        assert [one.points.tobytes() for one in seen] == [one.points.tobytes() for one in told]
        np.testing.assert_allclose([one.seconds for one in seen], [one.seconds for one in told], rtol=1e-9)
        if suffix == ".abc":
            write(again, found, iter(told))
            assert again.read_bytes() == path.read_bytes()
            assert Tree(path.read_bytes()).whole()
        else:
            assert (found.source.unit, found.source.up) == (1.0, "y")
            assert path.read_bytes().startswith(b"#usda" if suffix == ".usda" else b"PXR-USDC")


@pytest.fixture
def run(run: Runner) -> Runner:
    """Beside a file of strands that move."""
    write(Path("in.abc"), *moving())
    return run


def convert(run: Runner, name: str, *more: str) -> Path:
    run.fine("convert", "in.abc", name, *more)
    return Path(name)


def points(path: Path) -> list[Any]:
    """At each moment of a file."""
    return [one.points for one in kit.moments(path)]


@pytest.mark.parametrize("name", ["out.abc", "out.usd"])
def test_all_moments_are_written(run: Runner, name: str) -> None:
    target = convert(run, name)
    found = kit.moments(target)
    told = moving()[1]
    assert [one.points.tobytes() for one in found] == [one.points.tobytes() for one in told]
    np.testing.assert_allclose([one.seconds for one in found], [one.seconds for one in told], atol=1e-9)


def test_some_moments_are_written(run: Runner) -> None:
    told = [one.points.tobytes() for one in moving()[1]]
    assert [one.tobytes() for one in points(convert(run, "a.abc", "-f", "2-4x2"))] == [told[1], told[3]]
    assert [one.tobytes() for one in points(convert(run, "b.abc", "--frames", "3"))] == [told[2]]
    assert read(convert(run, "c.hair", "--frames", "3")).points.tobytes() == told[2]


def test_numbered_files_become_one(run: Runner) -> None:
    """File N is frame N; a moment that has other strands can be taken alone."""
    held, samples = moving()
    for number, one in enumerate(samples, 7):
        write(Path(f"in.{number:02d}.ply"), replace(held, points=one.points))
    run.fine("convert", "in.##.ply", "out.abc")
    found = kit.moments(Path("out.abc"))
    assert [one.points.tobytes() for one in found] == [one.points.tobytes() for one in samples]
    np.testing.assert_allclose([one.seconds for one in found], [number / FPS for number in range(7, 12)], atol=1e-9)
    write(Path("in.12.ply"), held.select(np.arange(held.count) > 0))
    assert "in.12.ply: has other strands" in run.refused("convert", "in.##.ply", "all.abc")
    run.fine("convert", "in.##.ply", "last.npz", "--frames", "6")
    assert read(Path("last.npz")).count == held.count - 1


def test_one_moment_of_several_is_told(run: Runner) -> None:
    done = run("convert", "in.abc", "a.hair")
    assert "the first of 5 is written, --frames chooses another" in done.err
    assert "asks for several moments" in run.refused("convert", "in.abc", "b.hair", "-f", "1-2")
    assert "moment 6" in run.refused("convert", "in.abc", "b.abc", "-f", "6")


@pytest.mark.parametrize(
    "edits",
    [
        ["--fix"], ["--strands", "3", "--reverse"],
        ["--min-length", "3", "--scale", "2"], ["--resample", "7"],
    ],
)  # fmt: skip
def test_edits_are_those_of_each_moment_alone(run: Runner, edits: list[str]) -> None:
    """But for what is chosen by the strands, which is chosen at the first moment."""
    found = points(convert(run, "all.abc", *edits))
    assert len(found) == FRAMES
    by_length = "--min-length" in edits
    for i, one in enumerate(found):
        if i and (by_length or "--fix" in edits):
            continue
        alone = convert(run, f"{i}.npz", "-f", str(i + 1), *edits)
        assert one.tobytes() == read(alone).points.tobytes()
    counts = read(Path("all.abc")).counts()
    if "--fix" in edits:
        assert counts.tolist() == moving()[0].counts()[:5].tolist()
        held = moving()[1]
        assert [one.tobytes() for one in found] == [one.points[:58].tobytes() for one in held]


def test_points_that_are_left_out_are_the_same_at_all_moments(run: Runner) -> None:
    found = points(convert(run, "a.abc", "--simplify", "0.5"))
    held = moving()[1]
    rows = [int(np.flatnonzero((held[0].points == one).all(axis=1))[0]) for one in found[0]]
    assert len(rows) < held[0].points.shape[0]
    # the last strand repeats the second, so that its rows are found there
    first = read(Path("a.abc")).first[-2]
    for one, told in zip(found, held, strict=True):
        assert one[:first].tobytes() == told.points[rows[:first]].tobytes()
