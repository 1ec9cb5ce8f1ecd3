"""`--watch` draws a frame again and again: what is simulated and placed anew, and what is not; the bits are those of a
run that knows nothing."""

from __future__ import annotations

from typing import Any

import numpy as np

import strandcli
from strandcli.groom import children
from strandcli.run.pipeline import render
from strandcli.run.remembered import Remembered
from strandcli.scene import Scene
from tests.run.test_checkpoints import SMALL, Steps


def scene_of(name: str = "hair", **more: Any) -> Scene:
    return strandcli.load(name, settings={**SMALL, **more})


def drawn(scene: Scene, frame: int, motion: Remembered | None) -> tuple[Any, int]:
    """The picture, and how many steps were simulated."""
    with Steps() as steps:
        (found,) = render(scene, [frame], threads=1, checkpoints=motion)
    return found.image, steps.count


def test_only_what_moves_strands_is_simulated_again(monkeypatch: Any) -> None:
    placed: list[int] = []
    monkeypatch.setattr(children, "family_of", _counting(placed, children.family_of))
    motion = Remembered(2)
    changes: list[dict[str, Any]] = [
        {}, {"lights.0.intensity": 1.0}, {"wind.strength": 5.0}, {"children.cut": 0.1}, {"seed": 2},
        {"camera.shutter": 0.5},
    ]  # fmt: skip
    for more, simulated, families in zip(changes, (1, 0, 1, 1, 1, 1), (1, 0, 0, 1, 1, 1), strict=True):
        scene, before = scene_of(**more), len(placed)
        image, steps = drawn(scene, 2, motion)
        assert (steps > 0, len(placed) - before) == (simulated, families), more
        np.testing.assert_array_equal(image, drawn(scene, 2, None)[0], err_msg=str(more))


def test_an_open_shutter_takes_the_frame_before() -> None:
    scene, motion = scene_of("minimal", **{"camera.shutter": 0.5, "camera.samples": 2}), Remembered(3)
    whole, steps = drawn(scene, 3, motion)
    assert steps > 1
    again, steps = drawn(scene, 3, motion)
    assert steps == scene.time.substeps
    np.testing.assert_array_equal(again, whole)


def _counting(calls: list[int], function: Any) -> Any:
    def counted(*words: Any) -> Any:
        calls.append(1)
        return function(*words)

    return counted
