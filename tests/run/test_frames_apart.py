"""A frame's pixels depend on the preset and its number alone; frames side by side come in order, each begun once."""

from __future__ import annotations

import dataclasses
import threading
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from strand_kit import frames_of, need_frames_at_once, require_alike, scene_of
from strandcli.run import pipeline
from strandcli.run.checkpoints import Checkpoints
from strandcli.run.ordered_map import ordered_map
from strandcli.scene.detail import GROWTH, needed_strands, tiers, tiers_of
from strandcli.scene.model import Scene
from tests.run.test_pipeline_extremes import EVERYTHING

FRAMES = 6
SCENE = """
time: {frames: 6, preroll: 0.1}
emitter: {strands: 700, particles: 5, length: 0.5, jitter: 20}
image: {size: [48, 36]}
material: {width: 0.01}
solids: [{kind: sphere, radius: 0.5}]
camera: {keys: [{time: 0, position: [0, 0, 30]}, {time: 0.2, position: [0, 0, 3]}]}
"""
DETAIL = "detail: {near: 3, fraction: 0.02}\n"
THESIS = "rules: [gravity, {wind: {strength: 5}}, {stiffness: {strength: 40}}, collision, elasticity]\n"
ROD = "solver: rod\nrules: [gravity, {wind: {strength: 5}}, collision]\n"
CASES = {
    "detail": SCENE + DETAIL + THESIS,
    "detail, rods": SCENE + DETAIL + ROD + "quality: default\n",
    "detail, blur": SCENE.replace("camera: {", "camera: {shutter: 0.5, samples: 3, ") + DETAIL + THESIS,
    "loop, blur": SCENE.replace("time: {", "time: {loop: true, ").replace("camera: {", "camera: {shutter: 0.5, ") + ROD,
    "detail, interaction": SCENE + DETAIL + ROD.replace("gravity", "gravity, interaction"),
    "detail, children": SCENE.replace("strands: 700", "strands: 300") + DETAIL + THESIS + "children: {count: 3}\n",
}


def drawn(scene: Scene, frames: list[int], **options: Any) -> dict[int, bytes]:
    found = {}
    for frame in pipeline.render(scene, frames, threads=1, **options):
        found[frame.number] = frame.image.tobytes()
    return found


def cache_of(scene: Scene) -> Callable[[int], np.ndarray]:
    found: dict[int, Any] = {}
    for frame in pipeline.render(scene, threads=1, draw=False, keep_positions=True):
        found[frame.number] = frame.positions
    return found.__getitem__


@pytest.mark.parametrize("name", CASES)
def test_pixels_of_a_frame_depend_on_its_number_alone(name: str, tmp_path: Path) -> None:
    scene = scene_of(CASES[name])
    whole = drawn(scene, list(range(1, FRAMES + 1)))
    assert len(set(whole.values())) == FRAMES

    def same(found: dict[int, bytes], what: str) -> None:
        assert [number for number, one in found.items() if one != whole[number]] == [], what

    same(drawn(scene, [3, 6]), "alone")
    same(drawn(scene, [2, 5], checkpoints=Checkpoints(tmp_path, 2)), "with checkpoints")
    same(drawn(scene, [4, 6], checkpoints=Checkpoints(tmp_path)), "from checkpoints")
    same(drawn(scene, [1, 4], positions=cache_of(scene)), "from a cache")


def test_tiers_are_whole_blocks_that_grow_and_end_with_all_strands() -> None:
    for total in (1, 127, 128, 129, 700, 100_000):
        ends = tiers(total)
        assert ends[-1] == total
        assert all(end % 128 == 0 for end in ends[:-1])
        assert all(a < b <= GROWTH * a + 128 for a, b in pairwise(ends))


def test_a_far_frame_is_drawn_from_few_strands_and_one_that_guides_or_acts_on_others_from_all() -> None:
    scene = scene_of(CASES["detail"])
    assert needed_strands(scene, [1]) < needed_strands(scene, [4]) < needed_strands(scene, [6]) == 700
    assert needed_strands(scene, [1, 6]) == needed_strands(scene, []) == 700
    for name in ("loop, blur", "detail, interaction", "detail, children"):
        assert tiers_of(scene_of(CASES[name])) == [scene_of(CASES[name]).emitter.strands]
    away = CASES["detail"].replace("30]", "4]").replace(", 3]}]", ", 30]}]")
    blurred = scene_of(away.replace("camera: {", "camera: {shutter: 0.5, "))
    assert needed_strands(blurred, [4]) == needed_strands(scene_of(away), [3, 4]) > needed_strands(scene_of(away), [4])


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
    require_alike(alone, together)
    assert (alone[5].image != alone[6].image).any()
