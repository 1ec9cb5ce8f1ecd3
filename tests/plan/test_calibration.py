"""The speed of a machine: measured, stored, believed only where it holds, and told by `plan`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cli_runs import TINY, Runner
from strand_kit import scene_of
from strandcli import calibration
from strandcli.calibration import Speed
from strandcli.compiling.folder import cache
from strandcli.plan import make_plan
from strandcli.plan.cost import run_seconds

KNOWN = Speed(1.5, "2026-01-31")


@pytest.fixture
def stored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the speed is stored: nowhere yet."""
    monkeypatch.setattr(cache, "_path", tmp_path)
    return tmp_path / calibration.FILE


@pytest.mark.parametrize(
    "change",
    [
        {}, {"factor": 0}, {"factor": True}, {"factor": "1"}, {"factor": 1e300}, {"schema_version": 2},
        {"machine": {"cpu": "another"}},
    ],
)  # fmt: skip
def test_what_was_stored_is_believed_unless_it_is_damaged_or_foreign(change: dict[str, object], stored: Path) -> None:
    assert calibration.read() is None
    assert calibration.write(KNOWN)
    stored.write_text(json.dumps({**json.loads(stored.read_text()), **change}))
    assert calibration.read() == (None if change else KNOWN)
    for content in (b"", b"{", b"[1]", b"\xff\xfe", b"[" * 100_000, b"null"):
        stored.write_bytes(content)
        assert calibration.read() is None


@pytest.mark.parametrize(
    "more",
    [
        "lights: [{kind: directional}, {kind: directional}, {kind: directional}]\n",
        "children: {count: 4}\n", "solver: rod\n", "time: {substeps: 40, frames: 12}\n",
        "camera: {aperture: 0.1, samples: 8}\n",
    ],
)  # fmt: skip
def test_time_grows_with_what_takes_it(more: str) -> None:
    text = TINY.replace("strands: 150", "strands: 20000").replace("time: {frames: 12}\n", "")
    if "solver" in more:
        text = text.replace("  - elasticity: {}\n", "")
    (plain, _), (other, _) = (
        run_seconds(make_plan(one, range(1, 5)), one) for one in (scene_of(text), scene_of(text + more))
    )
    assert other > 1.05 * plain


def test_time_grows_with_frames_and_falls_with_threads() -> None:
    scene = scene_of(TINY.replace("strands: 150", "strands: 20000"))
    each, whole = run_seconds(make_plan(scene, range(1, 5)), scene)
    assert run_seconds(make_plan(scene, range(1, 5)), scene, threads=2)[0] < each
    assert run_seconds(make_plan(scene, range(1, 9)), scene)[1] == pytest.approx(whole + 4 * each)
    before = scene_of(TINY.replace("strands: 150", "strands: 20000").replace("frames: 12", "frames: 12, preroll: 100"))
    assert run_seconds(make_plan(before, range(1, 5)), before)[1] > 1.2 * whole


def test_plan_tells_seconds_and_where_they_are_from(run: Runner, stored: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "time is not known" in run("plan", "tiny.yaml").out
    assert json.loads(run("plan", "tiny.yaml", "--json").out)["time"] is None
    calls = []
    monkeypatch.setattr(calibration, "measure", lambda notify: calls.append(1) or KNOWN)
    told = run("plan", "tiny.yaml", "--time", "--threads", 1).out
    assert "by a calibration of this machine on 2026-01-31" in told
    assert "for 12 frames on 1 thread, within a factor of 2" in told
    stored.write_text("damaged")
    run("plan", "tiny.yaml", "--time")
    data = json.loads(run("plan", "tiny.yaml", "--time", "--json").out)
    assert data["time"]["total"] > 12 * data["time"]["frame"] > 0
    assert len(calls) == 2  # once, and once more after the damage
    scene = scene_of(TINY)
    assert data["time"]["total"] == pytest.approx(
        run_seconds(make_plan(scene, range(1, 13)), scene, 1.5, data["time"]["threads"])[1]
    )


@pytest.mark.long
def test_the_machine_is_measured_and_doctor_stores_it(run: Runner, stored: Path) -> None:
    assert "times as long here" in run.fine("doctor", "--calibrate").err
    known = calibration.read()
    assert 0.05 < known.factor < 50
