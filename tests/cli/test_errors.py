"""Errors for programs and for people: nothing of libraries before the one line of an error, and what is meant by an
unknown option."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numba
import pytest

from cli_runs import Runner, environment
from strandcli.cli import main as module


@pytest.fixture
def run(run: Runner) -> Runner:
    Path("bad.yaml").write_text("title: x\nimage: {size: [0, 4]}\nemitter:\n  strandz: 5\n")
    return run


@pytest.mark.parametrize(
    ("arguments", "words", "code"),
    [
        (["render", "nonesuch"], "no preset 'nonesuch'", 2),
        (["render", "tiny.yaml", "--size", "9"], "not a width and a height", 2),
        (["render"], "Missing argument", 2),
        (["plan", "tiny.yaml", "--threads", "4096"], "this process may use", 2),
        (["compare", "a.png", "b.png"], "a.png: no such image", 2),
        (["simulate", "tiny.yaml", "-o", "bad.yaml"], "bad.yaml: ", 4),
    ],
)
def test_errors_are_one_line_of_json_with_json(run: Runner, arguments: list[str], words: str, code: int) -> None:
    plain, done = run(*arguments), run(*arguments, "--json")
    found = json.loads(done.error())
    assert list(found) == ["error", "exit_code", "faults"]
    assert words in found["error"]
    assert found["error"] in plain.error()
    assert done.code == plain.code == found["exit_code"] == code
    assert found["faults"] == []
    assert done.out == ""


def test_faults_of_a_preset_are_listed_with_their_places(run: Runner) -> None:
    done = run("plan", "bad.yaml", "--json")
    found = json.loads(done.error())
    assert done.code == 2
    assert [fault["path"] for fault in found["faults"]] == ["image.size", "emitter.strandz"]
    assert {"file": "bad.yaml", "line": 4, "column": 3}.items() <= found["faults"][1].items()
    assert "did you mean 'strands'?" in found["faults"][1]["message"]


def test_warnings_of_libraries_are_shown_only_where_they_are_asked_for(tmp_path: Path) -> None:
    program = (
        "import sys, warnings; from strandcli.cli import main; old = main.report\n"
        "def loud(*given): warnings.warn('overflow encountered', RuntimeWarning); return old(*given)\n"
        "main.report = loud; sys.argv = ['strandcli', 'plan', 'nonesuch']; sys.exit(main.main())"
    )
    lines = {}
    for shown in ("", "default"):
        variables = {**environment(), "PYTHONWARNINGS": shown}
        done = subprocess.run(
            [sys.executable, "-c", program], cwd=tmp_path, env=variables, capture_output=True, text=True
        )
        assert done.returncode == 2
        lines[shown] = done.stderr.splitlines()
    assert len(lines[""]) == 1
    assert any("overflow encountered" in line for line in lines["default"])
    assert os.listdir(tmp_path) == []


def test_a_kernel_that_cannot_run_without_the_compiler_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    fault = NotImplementedError("<intrinsic typed> is not usable in pure-python")
    assert module.report(fault, False) == 1
    assert "unexpected NotImplementedError" in capsys.readouterr().err
    monkeypatch.setattr(numba.config, "DISABLE_JIT", 1)
    assert module.report(fault, False) == 2
    told = capsys.readouterr().err
    assert told.startswith("strandcli: error: NUMBA_DISABLE_JIT is set")
    assert len(told.splitlines()) == 1


@pytest.mark.parametrize(
    ("option", "meant"),
    [
        ("--transparent", "'--transparent'; did you mean --set image.background=none? (see"),
        ("--resolution", "'--resolution'; did you mean --size? (see"),
        ("--motion-blur", "'--motion-blur'; did you mean --set camera.shutter=0.5? (see"),
        ("--fov", "'--fov'; did you mean --set camera.fov=…? (see"),
        ("--strnds", "'--strands'"),
    ],
)
def test_an_unknown_option_names_the_setting_that_is_meant(run: Runner, option: str, meant: str) -> None:
    assert meant in run.refused("render", "tiny.yaml", option)
    assert "--set" not in run("compare", option, "a", "b").error()


def test_suggested_settings_are_taken(run: Runner) -> None:
    from strandcli.scene.suggest import ELSEWHERE

    for setting in ELSEWHERE.values():
        assert run("plan", "tiny.yaml", "--set", setting).code == 0
