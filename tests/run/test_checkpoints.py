"""Checkpoints: a run that goes on from one has the very bits of a run from the start, whatever moves the strands; one
that is damaged or of something else is told of, not used, and made again."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest

import mesh_kit
import strandcli
from cli_runs import Runner
from strand_kit import require_alike
from strandcli.errors import RefusedError, SimulationError
from strandcli.meshes.mesh import TriangleMesh
from strandcli.output.files import temporary_name
from strandcli.run.checkpoints import FOLDER, Checkpoints, key_of, of_run
from strandcli.run.frame import Frame
from strandcli.run.pipeline import render
from strandcli.scene import Scene
from strandcli.simulate.rod.solver import RodSolver
from strandcli.simulate.rules import Pass, registry
from strandcli.simulate.rules.rule import Moment
from strandcli.simulate.solver import Solver
from strandcli.simulate.thesis.solver import ThesisSolver
from tests.run.test_pipeline_extremes import EVERYTHING

PRESETS = ("groom", "hair", "ponytail")
SMALL = {"emitter.strands": 70, "emitter.particles": 6, "image.size": [24, 20], "time.preroll": 0.1}
KEYS = [{"time": 0}, {"time": 0.5, "position": [0.3, 0.1, 0], "rotation": [10, 60, 20]}]
ROD = {"solver": "rod", "rules": ["emitter_motion", "gravity", "wind", {"collision": {"segments": True}}]}


def small(name: str, **more: Any) -> Scene:
    """A preset with few strands, which move."""
    settings = {"time.preroll": 0.1} if name == "groom" else SMALL
    return strandcli.load(name, settings={**settings, **more})


def everything(tmp_path: Path, **more: Any) -> Scene:
    """A scene that uses every stage of simulating."""
    path = tmp_path / "everything.yaml"
    path.write_text(EVERYTHING)
    return strandcli.load(str(path), settings={"time.frames": 9, **more})


def run(scene: Scene, frames: range | list[int], kept: Checkpoints | None = None, **more: Any) -> list[Frame]:
    return list(render(scene, frames, threads=1, keep_positions=True, checkpoints=kept, **{"draw": False, **more}))


def test_what_a_killed_run_has_begun_goes_though_nothing_is_left_to_simulate(tmp_path: Path) -> None:
    (tmp_path / FOLDER).mkdir()
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    begun = temporary_name(tmp_path / FOLDER / "frame_0002.state")
    begun = begun.with_name(begun.name.replace(f".{os.getpid()}.", f".{process.pid}."))
    begun.touch()
    assert of_run(tmp_path, None, pytest.fail) is not None
    assert not begun.exists()


@contextmanager
def counted_steps() -> Iterator[SimpleNamespace]:
    """Counts the steps of both solvers in a block."""
    steps = SimpleNamespace(count=0)

    def counted(kind: type[Solver]) -> Any:
        step = kind.step

        def one(solver: Solver, time: float, dt: float) -> None:
            steps.count += 1
            step(solver, time, dt)

        return patch.object(kind, "step", one)

    with counted(ThesisSolver), counted(RodSolver):
        yield steps


def goes_on(scene: Scene, folder: Path) -> None:
    """Frames 6 and 7 from the checkpoint of frame 4, written by a run that ended at 5, have the bits of one run."""
    whole = run(scene, [6, 7])
    run(scene, [5], Checkpoints(folder, 2))
    assert sorted(one.name for one in (folder / FOLDER).iterdir()) == ["frame_0002.state", "frame_0004.state"]
    with counted_steps() as steps:
        require_alike(run(scene, [6, 7], of_run(folder, None, pytest.fail)), whole)
    assert steps.count == 3 * scene.time.substeps


@pytest.mark.parametrize("name", PRESETS)
def test_presets_go_on_to_the_bit(name: str, tmp_path: Path) -> None:
    scene = small(name)
    if scene.emitter.groom is not None and scene.emitter.followers is None:  # nothing of a frame follows from others
        run(scene, [2], Checkpoints(tmp_path, 1))
        assert not (tmp_path / FOLDER).exists()
        return
    goes_on(scene, tmp_path)


@pytest.mark.parametrize("more", [
    {},
    {"time.loop": True},
    {**ROD, "rod.rest": "straight", "rod.tip": 0.05},
    {**ROD, "rod.rest": "sag_free", "time.substeps": 2},
    {**ROD, "solids.0.keys": KEYS, "solids.3.follow": "emitter", "rod.rest": "straight"},
    {**ROD, "rules": ["emitter_motion", {"wind": {"gust": 1, "wavelength": 2}}, "collision"]},
    {**ROD, "emitter.keys": [{"time": 0}, {"time": 0.55}, {"time": 0.56, "position": [9, 0, 0]}]},
])  # fmt: skip
def test_all_that_moves_goes_on_to_the_bit(more: dict[str, Any], tmp_path: Path) -> None:
    goes_on(everything(tmp_path, **more), tmp_path)


@pytest.mark.parametrize("solver", ["thesis", "rod"])
def test_roots_on_a_mesh_that_deforms_go_on_to_the_bit(solver: str, tmp_path: Path) -> None:
    files = []
    for k in range(3):
        box = mesh_kit.mesh("box")
        files.append(tmp_path / f"box_{k}.obj")
        files[-1].write_bytes(mesh_kit.obj(TriangleMesh(box.vertices * (1 + 0.2 * k), box.triangles, box.vertices)))
    shape = {"kind": "mesh", "file": str(files[0]), "deform": [
        {"time": 0.4 * k, "file": str(one)} for k, one in enumerate(files)
    ]}  # fmt: skip
    scene = strandcli.load("minimal", settings={
        "solver": solver, "rules": ["emitter_motion", "gravity"], "time.frames": 9,
        "emitter": {"strands": 40, "particles": 5, "shape": shape, "length": 0.5, "curl_turns": 2, "curl_angle": 20},
    })  # fmt: skip
    goes_on(scene, tmp_path)


def test_pictures_go_on_to_the_bit(tmp_path: Path) -> None:
    """With an open shutter, children and level of detail; frame by frame, and several frames apart."""
    more = {"camera.shutter": 0.5, "detail": {"near": 1}, "image.size": [24, 20]}
    scene = everything(tmp_path, **more)
    whole = run(scene, [2, 4, 5, 8], draw=True)
    require_alike(run(scene, [2, 4], Checkpoints(tmp_path, 4), draw=True), whole[:2], detail=True)
    with counted_steps() as steps:
        require_alike(run(scene, [5], of_run(tmp_path, None, pytest.fail), draw=True), whole[2:3], detail=True)
    assert steps.count == 1  # frame 4 is the moment before
    require_alike(run(scene, [4, 8], of_run(tmp_path, None, pytest.fail), draw=True), whole[1::2], detail=True)


def test_panels_have_checkpoints_of_their_own(tmp_path: Path) -> None:
    scene = small("solvers")
    assert len(scene.panels) > 1
    whole = run(scene, [3], draw=True)
    run(scene, [2], Checkpoints(tmp_path, 2), draw=True)
    assert {one.name for one in (tmp_path / FOLDER).iterdir()} == {
        f"panel_{k + 1}_frame_0002.state" for k in range(len(scene.panels))
    }
    with counted_steps() as steps:
        (found,) = run(scene, [3], of_run(tmp_path, None, pytest.fail), draw=True)
    np.testing.assert_array_equal(found.image, whole[0].image)
    assert steps.count == sum(panel.time.substeps for panel in scene.panels)


def test_a_damaged_one_is_told_of_and_made_again(tmp_path: Path) -> None:
    scene, heard = small("minimal"), list[str]()
    whole = run(scene, [8])
    run(scene, [6], Checkpoints(tmp_path, 2))
    path = tmp_path / FOLDER / "frame_0006.state"
    sound = path.read_bytes()
    for place in range(0, len(sound), len(sound) // 5):
        path.write_bytes(sound[:place] + bytes([sound[place] ^ 4]) + sound[place + 1 :])
        heard.clear()
        with counted_steps() as steps:
            require_alike(run(scene, [8], of_run(tmp_path, None, heard.append)), whole)
        assert steps.count == 4 * scene.time.substeps  # from frame 4
        assert len(heard) == 1
        assert "made again" in heard[0]
        assert "\n" not in heard[0]
        assert path.read_bytes() == sound


def test_one_of_another_scene_is_told_of_once_and_made_again(tmp_path: Path) -> None:
    heard: list[str] = []
    run(small("minimal"), [4], Checkpoints(tmp_path, 2))
    other = small("minimal", seed=7)
    whole = run(other, [5])
    require_alike(run(other, [5], Checkpoints(tmp_path, 2, heard.append)), whole)
    assert len(heard) == 1
    assert "another scene" in heard[0]
    with counted_steps() as steps:
        require_alike(run(other, [5], of_run(tmp_path, None, pytest.fail)), whole)
    assert steps.count == other.time.substeps


def test_the_key_follows_what_moves_strands_and_nothing_that_is_only_drawn(tmp_path: Path) -> None:
    key = key_of(small("minimal"))
    assert key == key_of(small("minimal", **{"image.size": [30, 30], "camera.position": [0, 0, 9], "time.frames": 77}))
    for more in ({"seed": 1}, {"time.substeps": 3}, {"emitter.strands": 71}, {"time.fps": 25}, {"solver": "rod"},
                 {"rules": ["gravity"]}, {"time.loop": True}):  # fmt: skip
        assert key_of(small("minimal", **more)) != key, more
    with patch("strandcli.jit.sources.digest", lambda module: module + " edited"):
        assert key_of(small("minimal")) != key


def test_a_run_that_goes_wrong_leaves_no_state_of_that(tmp_path: Path) -> None:
    bad = {"rules": [{"stiffness": {"strength": 1e9, "clamp": False}}, "gravity"], "emitter.jitter": 30.0}
    scene = small("minimal", **bad)
    heard: list[str] = []
    run(scene, [6], Checkpoints(tmp_path, 1, heard.append), keep_going=True, warn=heard.append)
    with pytest.raises(SimulationError, match=r"frame .* under the rules .*stiffness\.clamp: true"):
        run(scene, [8], of_run(tmp_path, None, pytest.fail))


class Remembering:
    """A rule that pulls harder with every step."""

    name, order = "remembering", 99.0
    Parameters = registry()["emitter_motion"].Parameters

    @staticmethod
    def passes(parameters: Any, scene: Scene) -> list[Pass]:
        kept = np.zeros(1, np.float32)

        def prepare(moment: Moment) -> Any:
            kept[0] += 0.001
            return np.array([0.0, -kept[0], 0.0], np.float32)

        return [Pass(registry()["gravity"].apply, prepare, "lane", 3, state=(kept,))]


def test_a_rule_that_remembers_is_kept(tmp_path: Path) -> None:
    with patch.dict(registry(), {"remembering": Remembering}):
        goes_on(small("minimal", rules=["remembering", "elasticity"]), tmp_path)


def test_a_full_disk_is_told_in_one_line(tmp_path: Path) -> None:
    (tmp_path / FOLDER).write_text("in the way")
    with pytest.raises(RefusedError, match="folder"):
        run(small("minimal"), [2], Checkpoints(tmp_path, 2))


def test_the_option(run: Runner) -> None:
    small_one = ("minimal", "--strands", 20, "--particles", 4, "-q")
    draw = ("render", *small_one, "--size", "24x20", "--threads", 1)
    run.fine(*draw, "-f", "1-6", "-o", "whole")
    run.fine(*draw, "-f", "1-4", "-o", "a", "--checkpoint", 3)
    with counted_steps() as steps:
        run.fine(*draw, "-f", "6", "-o", "a")
    assert steps.count == 3 * strandcli.load("minimal").time.substeps
    assert Path("a/frame_0006.png").read_bytes() == Path("whole/frame_0006.png").read_bytes()
    run.fine("simulate", *small_one, "-f", "3", "-o", "b", "--checkpoint", 3)
    assert Path("b", FOLDER, "frame_0003.state").is_file()
    assert "exclude each other" in run.refused("render", "minimal", "--from-cache", "b", "--checkpoint", 2)
