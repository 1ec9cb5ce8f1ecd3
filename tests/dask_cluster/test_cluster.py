"""`render --dask` with real clusters of processes: `make dask`, in an environment that has Dask."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("distributed", reason="runs by `make dask`")

from cli_runs import TINY, Runner, child, environment
from strand_kit import frames_of, scene_of
from strandcli.dask_cluster import cluster, worker
from strandcli.dask_cluster.worker import Job, Task
from strandcli.errors import RefusedError
from strandcli.output import png
from strandcli.run import pipeline
from strandcli.run.fingerprint import fingerprint

FRAMES = tuple(range(1, 9))


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of a scheduler with one worker of two threads, each a process that knows nothing of the tests."""
    folder = tmp_path_factory.mktemp("cluster")
    file = folder / "scheduler.json"
    dask = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
    started = [
        subprocess.Popen([*dask, "--port", "0", "--no-dashboard", "--scheduler-file", str(file)], env=environment(),
                         cwd=folder, stderr=subprocess.DEVNULL),
        subprocess.Popen([sys.executable, "-m", "distributed.cli.dask_worker", "--scheduler-file", str(file),
                          "--nthreads", "2", "--no-dashboard"], env=environment(), cwd=folder,
                         stderr=subprocess.DEVNULL),
    ]  # fmt: skip
    try:
        for _ in range(600):
            if file.exists() and file.stat().st_size:
                break
            time.sleep(0.1)
        yield json.loads(file.read_text())["address"]
    finally:
        for one in reversed(started):
            one.terminate()
            one.wait(30)


def hashes(folder: Path) -> dict[str, str]:
    """Pixels by file, of all frames that are there under their final names."""
    found = {}
    for path in sorted(folder.glob("frame_*.png")):
        image = png.load_frame(path, (64, 48))
        assert image is not None, path
        found[path.name] = json.loads((folder / "report.json").read_text())["frames"][len(found)]["pixels_sha256"]
    return found


def test_workers_of_this_machine_draw_the_same_pixels(run: Runner) -> None:
    assert run("render", "tiny.yaml", "-o", "plain", "--threads", 1).code == 0
    done = run.fine("render", "tiny.yaml", "-o", "spread", "--dask", "local", "--threads", 2)
    assert "12 frames in" in done.error()
    assert hashes(run.folder / "spread") == hashes(run.folder / "plain")
    assert len(hashes(run.folder / "plain")) == 12
    assert run("simulate", "tiny.yaml", "-o", "positions", "-q").code == 0
    run.fine("render", "tiny.yaml", "-o", "cached", "--from-cache", "positions", "--dask", "local", "--threads", 1)
    assert hashes(run.folder / "cached") == hashes(run.folder / "plain")


def test_a_scheduler_elsewhere(run: Runner, scheduler: str, monkeypatch: pytest.MonkeyPatch) -> None:
    run.fine("render", "tiny.yaml", "-f", "1-3", "-o", "spread", "--dask", scheduler)
    assert run("render", "tiny.yaml", "-f", "1-3", "-o", "plain", "--threads", 1).code == 0
    assert hashes(run.folder / "spread") == hashes(run.folder / "plain")
    mine = cluster.facts()
    monkeypatch.setattr(cluster, "facts", lambda: {**mine, "numba": "0.1"})
    warned = run.fine("render", "tiny.yaml", "-f", "1", "-o", "warned", "--dask", scheduler)
    assert f"has numba {mine['numba']}, and this machine 0.1; last bits of pixels may differ" in warned.err
    monkeypatch.setattr(cluster, "facts", lambda: {**mine, "strandcli": "0.0.1"})
    refused = run.refused("render", "tiny.yaml", "-f", "1", "-o", "refused", "--dask", scheduler)
    assert "has strandcli" in refused
    assert "install the same version everywhere" in refused


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nonsense", "nowhere://x"])
def test_an_address_where_nobody_answers(address: str, run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "PATIENCE", 1.0)
    done = run.refused("render", "tiny.yaml", "-f", "1", "--dask", address)
    assert f"--dask {address}: no scheduler answers there" in done


def pieces(client: Any) -> tuple[Job, Iterator[Task], list[int]]:
    """A run in tasks, and the processes of the workers."""
    scene = scene_of(TINY)
    moved = pipeline.render(scene, FRAMES, threads=1, draw=False, keep_positions=True)
    return (
        Job(scene, fingerprint(scene), FRAMES, threads=1),
        cluster.tasks_of(scene, FRAMES, moved),
        [*client.run(os.getpid).values()],
    )


def test_a_worker_that_is_killed_in_mid_work_costs_no_frame() -> None:
    warned: list[str] = []
    with cluster.connected("local", 2, warned.append) as client:
        job, tasks, processes = pieces(client)

        def killing() -> Iterator[Task]:
            for task in tasks:
                if task.number == 4:
                    os.kill(processes[0], signal.SIGKILL)
                yield task

        found = {frame.number: frame for frame in cluster.drawn(client, job, killing(), lambda: None)}
        assert processes[0] not in client.run(os.getpid).values()
    assert sorted(found) == list(FRAMES)
    for plain in frames_of(scene_of(TINY), *FRAMES):
        assert plain.image is not None
        assert (found[plain.number].image == plain.image).all()
    assert not warned


def kill_oneself(job: Job, task: Task) -> None:
    """In place of `worker.draw`: what drawing does to a worker that has too little memory."""
    os.kill(os.getpid(), signal.SIGKILL)


def test_a_frame_that_kills_every_worker_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    with cluster.connected("local", 1, print) as client:
        job, tasks, _ = pieces(client)
        monkeypatch.setattr(worker, "draw", kill_oneself)
        with pytest.raises(RefusedError, match=r"frame \d+: the last worker of several that died over it"):
            list(cluster.drawn(client, job, tasks, lambda: None))


def test_what_ends_the_run_leaves_whole_frames_and_no_process(run: Runner) -> None:
    (run.folder / "long.yaml").write_text(TINY.replace("frames: 12", "frames: 2000"))
    going = child(run.folder, "render", "long.yaml", "-o", "out", "--dask", "local", "--threads", 2)
    for _ in range(1200):
        if len(list((run.folder / "out").glob("frame_*.png"))) > 3:
            break
        time.sleep(0.1)
    going.send_signal(signal.SIGTERM)
    _, told = going.communicate(timeout=60)
    assert going.returncode == 143, told
    assert "--resume continues" in told
    assert "Traceback" not in told
    assert len(hashes(run.folder / "out")) > 3
    alive = subprocess.run(["ps", "-o", "pid=", "-g", str(going.pid)], capture_output=True, text=True)
    assert not alive.stdout.split()
