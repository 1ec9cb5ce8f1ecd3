"""`strandcli doctor`: a healthy machine is told so, and each disease by its name."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest
from PIL import Image

from cli_runs import Runner
from strandcli import doctor
from strandcli.common import limits
from strandcli.compiling.folder import cache
from strandcli.doctor import BROKEN, NOTE, OK, Finding, examine


def test_all_is_well_here(run: Runner) -> None:
    result = run("doctor", "--json")
    data = json.loads(result.out)
    assert (result.code, data["broken"]) == (0, []), result.out
    states = {one["check"]: one["state"] for one in data["checks"]}
    assert set(states) == {*examine.CHECKS, "temporary"}
    assert states["self-test"] == OK
    assert "exact" in data["checks"][-1]["text"] or "tolerance" in data["checks"][-1]["text"]


def test_what_is_broken_ends_in_exit_code_1(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails() -> Iterator[Finding]:
        raise OSError("no such luck")

    broken = Finding("numba", BROKEN, "cannot be imported\x1b[2J", "install it")
    checks = {"disk": fails, "numba": lambda: iter([broken]), "self-test": examine.picture}
    monkeypatch.setattr(examine, "CHECKS", checks)
    result = run("doctor")
    assert result.code == 1
    assert result.err == "broken: disk, numba, self-test\n"
    assert "BROKEN disk       OSError: no such luck" in result.out
    assert "BROKEN self-test  not run\n                  mend numba first" in result.out
    assert "\x1b" not in result.out
    quiet = run("doctor", "-q")
    assert (quiet.code, quiet.err) == (1, "")


def test_a_picture_that_differs_is_broken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "golden"
    shutil.copytree(examine.GOLDEN, folder)
    monkeypatch.setattr(examine, "GOLDEN", folder)
    good = examine.draw()
    assert good["matches"]
    assert examine.self_test(0, json.dumps(good), "").state == OK
    listed = folder / "golden.yaml"
    listed.write_text(listed.read_text().replace("strands=400", "strands=399"))
    wrong = examine.self_test(0, json.dumps(examine.draw()), "")
    assert wrong.state == BROKEN
    assert "pictures are wrong here" in wrong.advice
    assert (Image.open(folder / "self-test.png").size) == (96, 72)


def test_a_self_test_that_ends_otherwise_is_told() -> None:
    assert "SIGSEGV" in examine.self_test(-11, "", "").text
    assert examine.self_test(1, "", "Traceback\nImportError: no numba\n").text == "ImportError: no numba"
    assert examine.self_test(0, '{"error": "UsageError: unset it"}\n', "").text == "UsageError: unset it"
    assert examine.self_test(1, "", "").text == "exit code 1"


@pytest.mark.parametrize("version", [1, 2])
def test_limits_of_control_groups_are_the_least_of_all_that_a_process_is_in(version: int, tmp_path: Path) -> None:
    """Of cores' time and of memory; what is left of that is in `tests/run/test_plan_memory.py`."""
    self_test = tmp_path / "told"
    self_test.write_text("0::/user/job\n" if version == 2 else "4:cpu,cpuacct:/user/job\n3:memory:/user/job\n")
    inner = tmp_path / ("" if version == 2 else "memory") / "user/job"
    cpu = tmp_path / ("" if version == 2 else "cpu") / "user/job"
    for folder in (inner, cpu):
        folder.mkdir(parents=True, exist_ok=True)
    assert limits.quota(tmp_path, self_test) is None
    for folder, quota in ((cpu, "max"), (cpu.parent, "150000")):
        if version == 2:
            (folder / "cpu.max").write_text(f"{quota} 100000\n")
        else:
            (folder / "cpu.cfs_quota_us").write_text(quota.replace("max", "-1"))
            (folder / "cpu.cfs_period_us").write_text("100000")
    name = "memory.max" if version == 2 else "memory.limit_in_bytes"
    for folder, bytes_ in ((inner, "max" if version == 2 else 2**63 - 4096), (inner.parent, 5000)):
        (folder / name).write_text(f"{bytes_}\n")
    (inner.parents[1] / name).write_text("7000\n")
    assert limits.quota(tmp_path, self_test) == 1.5
    assert limits.memory(tmp_path, self_test) == 5000


def test_fewer_cores_than_threads_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(limits, "quota", lambda: 1.0)
    monkeypatch.setattr(doctor, "checked_threads", lambda threads: 4)
    (found,) = doctor.threads()
    assert (found.state, "--threads 1" in found.advice) == (NOTE, True)
    monkeypatch.setattr(limits, "quota", lambda: 4.0)
    (found,) = doctor.threads()
    assert found.state == OK


def test_the_kernels_folder_tells_damage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tmp_path.chmod(0o700)
    monkeypatch.setattr(cache, "_path", tmp_path)
    monkeypatch.setattr(cache, "_trouble", None)
    good = tmp_path / f"a.b-{'0' * 24}.kernel"
    good.write_bytes(doctor.FIRST_BYTES + bytes(2000))
    (tmp_path / "another file").write_text("not strandcli's")
    (found,) = doctor.kernels()
    assert (found.state, "1 kernel or module," in found.text) == (OK, True)
    for content in (b"", doctor.FIRST_BYTES, bytes(3000)):
        good.with_name(f"a.c-{'1' * 24}.kernel").write_bytes(content)
        (found,) = doctor.kernels()
        assert (found.state, "1 not used" in found.text) == (NOTE, True)
    monkeypatch.setattr(cache, "_trouble", "kernels cannot be kept")
    (found,) = doctor.kernels()
    assert found == Finding("cache", NOTE, "kernels cannot be kept")


def test_versions_that_are_too_old_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    assert doctor.numbers("2.0.1rc3") == (2, 0)
    monkeypatch.setattr(doctor, "LEAST", {"numba": (999, 0), "no-such-package": (1, 0)})
    (found,) = doctor.versions()
    assert found.state == BROKEN
    assert "too old: numba" in found.text
    assert "missing: no-such-package" in found.text


def test_bytecode_that_nobody_keeps_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def found(kept: bool, told_not_to: bool) -> Finding:
        path = tmp_path / "numba" / "__init__.py"
        path.parent.mkdir(exist_ok=True)
        path.touch()
        there = tmp_path / f"kept-{kept}"
        monkeypatch.setattr(doctor.importlib.util, "find_spec", lambda name: SimpleNamespace(origin=str(path)))
        monkeypatch.setattr(doctor.importlib.util, "cache_from_source", lambda origin: str(there))
        monkeypatch.setattr(doctor.sys, "dont_write_bytecode", told_not_to)
        if kept:
            there.touch()
        (one,) = doctor.bytecode()
        return one

    assert [found(kept, self_test).state for kept in (True, False) for self_test in (True, False)] == [OK, OK, NOTE, OK]
    assert f"compileall -q {tmp_path}" in found(False, True).advice
