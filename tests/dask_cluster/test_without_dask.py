"""`render --dask`: what holds without Dask being installed: refusals, tasks, and what a worker draws."""

from __future__ import annotations

import dataclasses
import pickle
import sys

import numpy as np
import pytest

from cli_runs import TINY, Runner
from strand_kit import frames_of, scene_of
from strandcli.dask_cluster import cluster, worker
from strandcli.dask_cluster.worker import Job, Task
from strandcli.errors import UsageError
from strandcli.run import pipeline
from strandcli.run.fingerprint import fingerprint
from strandcli.run.frame import Frame
from strandcli.scene import Scene
from strandcli.scene.detail import with_before

BLURRED = TINY + "camera: {shutter: 0.5, samples: 2}\n"


def test_a_missing_package_is_told_with_what_brings_it(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert run.refused("render", "tiny.yaml", "--dask", "local").endswith(" 'distributed>=2024.1'")
    assert not (run.folder / "out").exists()


@pytest.mark.parametrize(
    ("preset", "more", "words"),
    [
        ("solvers", (), "--dask: a preset of several panels"),
        ("tiny.yaml", ("--max-error", "0.01"), "--dask and --max-error exclude each other"),
    ],
)
def test_what_goes_not_with_it_is_refused(preset: str, more: tuple[str, ...], words: str, run: Runner) -> None:
    assert words in run.refused("render", preset, "--dask", "local", *more)
    assert run("render", "tiny.yaml", "--dask", " ").code == 2


def tasks(scene: Scene, numbers: tuple[int, ...]) -> tuple[Job, list[Task]]:
    """A run as it is handed to workers, which get copies of all."""
    moved = pipeline.render(scene, with_before(scene, numbers), threads=1, draw=False, keep_positions=True)
    job = Job(scene, fingerprint(scene), numbers, threads=1)
    sent: tuple[Job, list[Task]] = pickle.loads(pickle.dumps((job, list(cluster.tasks_of(scene, numbers, moved)))))
    return sent


@pytest.mark.parametrize("text", [TINY, BLURRED])
def test_a_worker_draws_the_very_frames_of_a_plain_run_in_any_order(text: str) -> None:
    scene = scene_of(text)
    plain = {frame.number: frame for frame in frames_of(scene, 1, 2, 4)}
    job, found = tasks(scene, (1, 2, 4))
    assert [sorted(task.positions) for task in found][-1] == ([3, 4] if scene.camera.shutter else [4])
    for task in reversed(found):
        frame = worker.draw(job, task)
        assert isinstance(frame, Frame), frame
        np.testing.assert_array_equal(frame.image, plain[task.number].image)
        assert frame.report["counts"] == plain[task.number].report["counts"]
        assert frame.report["error"] == plain[task.number].report["error"]
        assert frame.report["seconds"]["simulate"] is not None


def test_a_worker_whose_scene_is_another_returns_what_is_wrong() -> None:
    scene = scene_of(TINY)
    job, (task,) = tasks(scene, (1,))
    found = worker.draw(dataclasses.replace(job, fingerprint="another"), task)
    assert isinstance(found, UsageError)
    assert "give all machines the same files" in str(found)


def test_what_goes_wrong_in_a_scene_is_returned_so_that_nobody_tries_again() -> None:
    scene = scene_of(TINY)
    job, (task,) = tasks(scene, (1,))
    positions = {1: np.full_like(task.positions[1], np.nan)}
    found = worker.draw(job, dataclasses.replace(task, positions=positions))
    assert "--keep-going" in str(found)
