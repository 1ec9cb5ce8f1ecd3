"""Frames side by side: in order, each begun once and in its turn, errors at their frame, no thread left over."""

from __future__ import annotations

import dataclasses
import threading
import time
from collections.abc import Callable, Iterator

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from strand_kit import frames_of, need_frames_at_once, scene_of
from strandcli.run import pipeline
from strandcli.run.ordered_map import ordered_map
from tests.run.test_pipeline_extremes import EVERYTHING


def counted(most: int, seen: list[int]) -> Iterator[int]:
    for number in range(most):
        seen.append(number)
        yield number


@given(st.integers(0, 12), st.integers(1, 4), st.randoms(use_true_random=False))
def test_results_come_ordered_map_however_long_each_takes(items: int, workers: int, random: object) -> None:
    waits = [random.random() * 2e-3 for _ in range(items)]  # type: ignore[attr-defined]
    begun: list[int] = []
    inside: list[int] = []

    def begin(item: int) -> int:
        inside.append(1)
        assert len(inside) == 1, "two in the sequential stage"
        begun.append(item)
        inside.pop()
        return item

    def finish(item: int) -> int:
        time.sleep(waits[item])
        return item * item

    assert list(ordered_map(range(items), begin, [finish] * workers)) == [i * i for i in range(items)]
    assert begun == list(range(items))


@pytest.mark.parametrize("where", ["begin", "finish"])
@pytest.mark.parametrize("bad", [0, 3])
def test_an_error_comes_after_the_frames_before_it(where: str, bad: int) -> None:
    def fail_at(place: str) -> Callable[[int], int]:
        def step(item: int) -> int:
            if item == bad and place == where:
                raise ArithmeticError(f"frame {item}")
            return item

        return step

    found = ordered_map(range(10), fail_at("begin"), [fail_at("finish")] * 3)
    assert [next(found) for _ in range(bad)] == list(range(bad))
    with pytest.raises(ArithmeticError, match=f"frame {bad}"):
        next(found)
    assert not [one for one in threading.enumerate() if one.name.startswith("frames")]


def test_leaving_early_stops_the_threads_and_nobody_runs_far_ahead() -> None:
    seen: list[int] = []
    found = ordered_map(counted(1000, seen), lambda item: item, [lambda item: item] * 2)
    assert [next(found), next(found)] == [0, 1]
    time.sleep(0.05)
    found.close()
    assert len(seen) <= 2 + 4
    assert not [one for one in threading.enumerate() if one.name.startswith("frames")]


@pytest.mark.skipif(numba.config.NUMBA_NUM_THREADS < 2, reason="this machine has one core")  # type: ignore[attr-defined]
def test_frames_drawn_side_by_side_are_those_drawn_one_after_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    need_frames_at_once()
    scene = scene_of(EVERYTHING)
    scene = dataclasses.replace(scene, emitter=dataclasses.replace(scene.emitter, strands=300))
    numbers, threads = range(1, 10), [2, 2, *[1] * 6, 2]  # the last frame has no other beside it
    alone = frames_of(scene, *numbers, threads=1)
    monkeypatch.setattr(pipeline, "_frames_at_once", lambda *args: 2)
    together = frames_of(scene, *numbers, threads=2)
    assert [frame.report["threads"] for frame in together] == threads
    for a, b in zip(alone, together, strict=True):
        assert a.number == b.number
        np.testing.assert_array_equal(a.image, b.image)
        np.testing.assert_array_equal(a.positions, b.positions)
        assert a.report["error"] == b.report["error"]
        assert a.report["counts"] == b.report["counts"]
    assert (alone[5].image != alone[6].image).any()
