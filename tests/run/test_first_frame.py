"""States that an earlier run left: the same bits, and what moves strands otherwise begins anew."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import strandcli
from strandcli.compiling import folder
from strandcli.jit import kept as keeping
from strandcli.run import checkpoints as first_frame
from strandcli.run.checkpoints import Checkpoints
from strandcli.run.frame import Frame
from strandcli.run.pipeline import render
from strandcli.scene import Scene
from tests.run.test_checkpoints import SMALL, Steps, alike

SOME = {"time.preroll": 0.5}


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder for states; kernels stay in the cache's. However short the simulation, its state is kept."""
    new = folder.Folder()
    new.use(tmp_path / "cache")
    new.path.mkdir(mode=0o700)
    monkeypatch.setattr(keeping, "folder", SimpleNamespace(cache=new))
    monkeypatch.setattr(first_frame, "LEAST", 0)
    return new.path


def scene_of(name: str = "hair", **more: Any) -> Scene:
    return strandcli.load(name, settings={**SMALL, **SOME, **more})


def run(scene: Scene, frames: list[int], kept: Any = None, **more: Any) -> tuple[list[Frame], int]:
    """Frames, and how many steps were simulated."""
    with Steps() as steps:
        found = list(render(scene, frames, threads=1, keep_positions=True, checkpoints=kept, **more))
    return found, steps.count


@pytest.mark.parametrize("name", ["hair", "solvers"])
def test_a_later_run_has_the_bits_of_the_first(name: str) -> None:
    scene = scene_of(name)
    plain, whole = run(scene, [1, 3])
    first, simulated = run(scene, [1, 3], Checkpoints(None))
    assert simulated == whole
    later, fewer = run(scene, [1, 3], Checkpoints(None))
    assert fewer < whole
    assert run(scene, [1], Checkpoints(None))[1] == 0
    for found in first, later:
        for a, b in zip(plain, found, strict=True):
            np.testing.assert_array_equal(a.image, b.image)
            np.testing.assert_array_equal(a.positions, b.positions)
            assert a.report["error"] == b.report["error"]


def test_only_what_moves_strands_begins_anew(place: Path) -> None:
    told: list[str] = []
    steps = []
    changes: list[dict[str, Any]] = [
        {}, {"lights.0.intensity": 1.0}, {"camera.fov": 30.0}, {"wind.strength": 5.0}, {"time.preroll": 0.6},
        {"emitter.strands": 71},
    ]  # fmt: skip
    for more in changes:
        scene = scene_of(**more)
        found, simulated = run(scene, [1], Checkpoints(None, notify=told.append))
        assert found[0].report.get("went_on_from") == (None if simulated else 1)
        steps.append(simulated > 0)
        np.testing.assert_array_equal(found[0].image, run(scene, [1])[0][0].image)
    assert steps == [True, False, False, True, True, True]
    assert told.count("frame 1 as an earlier run left it") == 2
    assert len(list(place.glob("first-frame-*.arrays"))) == 4


def test_a_scene_without_preroll_and_a_short_one_leave_nothing(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run(scene_of(**{"time.preroll": 0}), [1, 2], Checkpoints(None))
    monkeypatch.setattr(first_frame, "LEAST", 1e9)
    run(scene_of(), [1], Checkpoints(None))
    assert list(place.glob("first-frame-*")) == []


def test_checkpoints_of_the_run_go_before(tmp_path: Path) -> None:
    scene = scene_of()
    plain, whole = run(scene, [3], Checkpoints(tmp_path, 2))
    again, simulated = run(scene, [3], Checkpoints(tmp_path, 2))
    assert 0 < simulated == scene.time.substeps < whole
    assert again[0].report["went_on_from"] == 2
    alike(plain, again)
