"""Completion in shells: what is offered, that a real shell takes it, and that it is quick."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from cli_runs import TINY, environment
from strandcli.cli.completion import register
from strandcli.cli.main import cli


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a preset, a file of strands, another file, and a command `strandcli`."""
    (tmp_path / "tiny.yaml").write_text(TINY)
    (tmp_path / "hairy.abc").write_text("")
    (tmp_path / "notes.txt").write_text("")
    (tmp_path / "bin").mkdir()
    command = tmp_path / "bin/strandcli"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m strandcli "$@"\n')
    command.chmod(0o755)
    return tmp_path


@pytest.mark.parametrize(("line", "some", "none"), [
    ("strandcli ", ["render", "doctor", "new"], []),
    ("strandcli co", ["compare", "convert", "completion"], ["render"]),
    ("strandcli nonsense --", ["--version"], ["--overwrite"]),
    ("strandcli render h", ["hair", "headline"], ["fur", "notes.txt"]),
    ("strandcli presets copy f", ["fox", "fur", "figures/fig02"], ["hair"]),
    ("strandcli render hair --set ", ["material.", "seed=", "wind."], ["stiffness.", "panels.", "extends="]),
    ("strandcli render --set st", ["stiffness."], ["gravity."]),
    ("strandcli render hair --set image.resolver=", ["image.resolver=sorted"], ["image.resolver="]),
    ("strandcli render hair --set time.loop=t", ["time.loop=true"], ["time.loop=false"]),
    ("strandcli render hair --set solids.", ["solids.head.", "solids.0."], ["solids.1."]),
    ("strandcli render hair --set solids.head.co", ["solids.head.coat="], ["solids.head.cap="]),
    ("strandcli render hair --set lights.2.shadow.m", ["lights.2.shadow.model="], []),
    ("strandcli render hair --set nonsense.", [], ["seed="]),
    ("strandcli render hair --set wind.strength=1 --set wind.", ["wind.gust="], []),
    ("strandcli render hair --aov depth,", ["depth,mask"], ["depth,depth"]),
    ("strandcli render hair --animate gif,", ["gif,webp"], []),
    ("strandcli render hair --quality ", ["best"], []),
])  # fmt: skip
def test_what_is_offered(
    folder: Path, line: str, some: list[str], none: list[str], monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    """What the command answers to Bash for a line."""
    monkeypatch.chdir(folder)
    monkeypatch.setenv("_STRANDCLI_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_LINE", line)
    register()
    with pytest.raises(SystemExit):
        cli.main(args=[], prog_name="strandcli")
    told = capsys.readouterr()
    assert told.err == ""
    found = [one.partition(",")[2] for one in told.out.splitlines()]
    assert set(some) <= set(found)
    assert not set(none) & set(found)


def test_neither_numpy_nor_numba_is_imported_and_it_takes_a_moment(folder: Path) -> None:
    """Counted in processor time; 2 s is the point from which a person notices, on a machine of any speed."""
    code = "import resource, sys\nfrom strandcli.cli.main import main\nsys.argv = ['strandcli']\ntry:\n    main()\n"
    code += "finally:\n    print(sorted({'numpy', 'numba', 'PIL'} & set(sys.modules)), file=sys.stderr)\n"
    told = {"_STRANDCLI_COMPLETE": "bash_complete", "COMP_LINE": "strandcli render hair --set material."}
    done = subprocess.run([sys.executable, "-c", code], cwd=folder, env={**environment(), **told}, capture_output=True,
                          text=True)  # fmt: skip
    assert "material.pigment=" in done.stdout
    assert done.stderr == "[]\n"


def test_bash_completes_a_key_and_its_value(folder: Path) -> None:
    """= ends a word for Readline: what stands before it is not repeated."""
    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("no bash")
    script = """
        set -eu
        compopt() { :; }
        eval "$(strandcli completion bash)"
        for COMP_LINE in "strandcli plan fur --set image.reso" "strandcli plan --set image.resolver=s" "strandcli ren"
        do
            COMP_POINT=${#COMP_LINE}; _strandcli_completion strandcli; echo "${COMPREPLY[@]}"
        done
    """
    path = {"PATH": f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(
        [bash, "-c", script], cwd=folder, env={**environment(), **path}, capture_output=True, text=True
    )
    assert done.stdout.splitlines() == ["image.resolver=", "sorted", "render"], done.stderr


def test_a_shell_that_is_not_known_is_told(folder: Path) -> None:
    done = subprocess.run([sys.executable, "-m", "strandcli", "completion"], cwd=folder, capture_output=True, text=True,
                          env={**environment(), "SHELL": "/bin/tcsh"})  # fmt: skip
    assert done.returncode == 2
    assert "name bash, zsh or fish" in done.stderr
