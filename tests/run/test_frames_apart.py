"""A frame's pixels are a function of the preset and its number, whichever others are asked for, and from whatever
state, positions or chunk it is drawn."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from strand_kit import scene_of
from strandcli.run import pipeline
from strandcli.run.checkpoints import Checkpoints
from strandcli.scene.detail import GROWTH, needed_strands, tiers, tiers_of
from strandcli.scene.model import Scene

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
        assert frame.image is not None
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
