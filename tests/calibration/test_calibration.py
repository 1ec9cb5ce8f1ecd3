"""The speed of a machine: measured, kept, believed only where it holds, refined, and told by `plan`."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from cli_runs import TINY, Runner
from strand_kit import scene_of
from strandcli.calibration import measure, profile, speed
from strandcli.calibration.speed import foretell
from strandcli.compiling.folder import cache
from strandcli.plan import libraries, make_plan
from strandcli.plan.cost import frame_seconds, kind_of, run_seconds
from strandcli.run.frame import Frame


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the profile is kept: nowhere yet."""
    monkeypatch.setattr(cache, "_path", tmp_path)
    return tmp_path / profile.FILE


def test_a_profile_is_what_was_kept(kept: Path) -> None:
    assert profile.read() is None
    known = profile.Profile(1.5, "2026-01-31")
    known.learn("a", 2.0)
    assert profile.write(known)
    assert profile.read() == known
    assert known.of("a") == (2.0, 1)
    assert known.of("b") == (1.5, 0)


@pytest.mark.parametrize(
    "change",
    [
        {"factor": 0}, {"factor": True}, {"factor": "1"}, {"factor": 1e300}, {"schema_version": 2}, {"kinds": 3},
        {"kinds": {"a": {"factor": 1, "runs": 0}}}, {"kinds": {"a": 1}}, {"machine": {"cpu": "another"}},
    ],
)  # fmt: skip
def test_a_damaged_or_foreign_profile_is_as_none(change: dict[str, object], kept: Path) -> None:
    profile.write(profile.Profile(1.5, "2026-01-31"))
    kept.write_text(json.dumps({**json.loads(kept.read_text()), **change}))
    assert profile.read() is None


@pytest.mark.parametrize("content", [b"", b"{", b"[1]", b"\xff\xfe", b"[" * 100_000, b"null"])
def test_what_is_no_profile_is_as_none(content: bytes, kept: Path) -> None:
    kept.write_bytes(content)
    assert profile.read() is None


def test_newer_runs_count_more_and_nonsense_does_not() -> None:
    known = profile.Profile(1.0, "2026-01-31")
    for _ in range(20):
        known.learn("a", 1.0)
    for _ in range(8):
        known.learn("a", 3.0)
    assert 2.4 < known.of("a")[0] < 3.0
    before = known.of("a")
    for factor in (0.0, 1e9, float("nan")):
        known.learn("a", factor)
    assert known.of("a") == before


def frames(numbers: list[int]) -> Iterator[Frame]:
    for number in numbers:
        yield Frame(number, None, None, {})


def test_a_run_teaches_by_the_frames_after_the_first(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = scene_of(TINY)
    plan = make_plan(scene, range(1, 5))
    expected = frame_seconds(plan, scene)
    ticks = [100.0, 100.0 + 3 * expected, 100.0 + 6 * expected, 100.0 + 9 * expected]
    for numbers, runs in (([1, 2, 3, 4], 1), ([1, 2, 3, 5], 0), ([1, 2], 0)):
        profile.write(profile.Profile(1.0, "2026-01-31"))
        clock = iter(ticks)
        monkeypatch.setattr(speed.time, "process_time", lambda clock=clock: next(clock))
        watch = speed.Watch()
        assert [frame.number for frame in watch.over(frames(numbers))] == numbers
        speed.learn(plan, scene, watch)
        known = profile.read()
        assert known is not None
        factor, found = known.of(kind_of(scene))
        assert found == runs
        assert factor == pytest.approx(3.0 if runs else 1.0)


def test_time_grows_with_what_takes_it() -> None:
    def seconds(more: str, threads: int = 1, numbers: range = range(1, 5)) -> tuple[float, float]:
        scene = scene_of(TINY.replace("strands: 150", "strands: 20000") + more)
        return run_seconds(make_plan(scene, numbers), scene, 1.0, threads)

    base = seconds("")
    for more in (
        "lights: [{kind: directional}, {kind: directional}, {kind: directional}]\n",
        "children: {count: 4}\n", "solver: rod\n", "time: {substeps: 40, frames: 12}\n",
        "camera: {aperture: 0.1, samples: 8}\n",
    ):  # fmt: skip
        text = TINY.replace("strands: 150", "strands: 20000").replace("time: {frames: 12}\n", "")
        if "solver" in more:
            text = text.replace("  - elasticity: {}\n", "")
        scene = scene_of(text + more)
        assert run_seconds(make_plan(scene, range(1, 5)), scene)[0] > 1.05 * base[0], more
    assert seconds("", threads=2)[0] < base[0]
    assert seconds("", numbers=range(1, 9))[1] == pytest.approx(base[1] + 4 * base[0])
    before = scene_of(TINY.replace("strands: 150", "strands: 20000").replace("frames: 12", "frames: 12, preroll: 100"))
    assert run_seconds(make_plan(before, range(1, 5)), before)[1] > 1.2 * base[1]
    assert foretell(make_plan(scene_of(TINY), [1]), scene_of(TINY), profile.Profile(2.0, "2026-01-31"), 1).total == (
        pytest.approx(2 * run_seconds(make_plan(scene_of(TINY), [1]), scene_of(TINY))[1])
    )


def test_plan_tells_seconds_and_where_they_are_from(run: Runner, kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "time is not known" in run("plan", "tiny.yaml").out
    assert json.loads(run("plan", "tiny.yaml", "--json").out)["time"] is None
    calls = []
    monkeypatch.setattr(measure, "measure", lambda notify: calls.append(1) or profile.Profile(2.0, "2026-01-31"))
    told = run("plan", "tiny.yaml", "--time", "--threads", 1).out
    assert "by a calibration of this machine on 2026-01-31" in told
    assert "for 12 frames on 1 thread, within a factor of 2" in told
    kept.write_text("damaged")
    run("plan", "tiny.yaml", "--time")
    data = json.loads(run("plan", "tiny.yaml", "--time", "--json").out)
    assert data["time"]["total"] > 12 * data["time"]["frame"] > 0
    assert len(calls) == 2  # once, and once more after the damage
    known = profile.read()
    assert known is not None
    known.learn(kind_of(scene_of(TINY)), 7.0)
    profile.write(known)
    assert "by the last run of such scenes here" in run("plan", "tiny.yaml").out


@pytest.mark.long
def test_the_machine_is_measured_and_doctor_keeps_it(run: Runner, kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen = iter([40e6, 90e6, 120e6, *[30e6] * 100])  # pages that the system takes back do not count as never taken
    with monkeypatch.context() as patched:
        patched.setattr(measure, "mapped_bytes", lambda: int(next(seen)))
        patched.setattr(libraries, "mapped_bytes", lambda: 30_000_000)
        patched.setattr(libraries, "_is_own", lambda: True)
        assert 0.05 < measure.measure().factor < 50
    assert libraries._kept() == {libraries._environment(): 120_000_000}
    done = run("doctor", "--calibrate")
    assert done.code == 0
    assert "times as long here" in done.err
    assert profile.read() is not None
