"""What libraries are told in a process of our own, and the command that installs an optional package."""

from __future__ import annotations

import platform
import subprocess
import sys
import sysconfig
import tomllib
from pathlib import Path

import pytest

from strandcli.common import extras


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="counts threads as Linux lists them")
def test_products_of_matrices_start_no_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    script = (
        "import os; from strandcli.compiling import runtime; runtime.still_idle_threads(); import numpy as np;"
        "a = np.ones((500, 500)); a @ a; print(len(os.listdir('/proc/self/task')))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert int(done.stdout) == 1


LARGE_ARRAYS = """
import sys
import numpy as np
from strandcli.compiling import runtime
if sys.argv[1] == "at once":
    runtime.give_back_large()
np.ones(30_000_000, np.uint8)  # from now on, arrays of this size are among others
first, between = np.ones(20_000_000, np.uint8), np.ones(100_000, np.uint8)
del first
for line in open("/proc/self/status"):
    if line.startswith("RssAnon"):
        print(1024 * int(line.split()[1]))
"""


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="a setting of GNU's C library")
def test_large_arrays_that_are_freed_go_back_to_the_system(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MALLOC_MMAP_THRESHOLD_", raising=False)
    usual, at_once = (
        int(
            subprocess.run([sys.executable, "-c", LARGE_ARRAYS, how], capture_output=True, text=True, check=True).stdout
        )
        for how in ("usual", "at once")
    )
    assert at_once < usual - 15_000_000


ROOT = Path(__file__).resolve().parents[2]


def test_requirements_are_those_of_the_package() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    declared = project["optional-dependencies"]
    assert {name: [one] for name, one in extras.REQUIREMENTS.items()} == {
        name: declared[name] for name in declared if name != "check"
    }


@pytest.mark.parametrize(
    ("there", "pip", "which", "command"),
    [
        ("", True, None, "{home}/bin/python -m pip install 'OpenEXR>=3.3'"),
        ("", True, "{home}/bin/pip", "pip install 'OpenEXR>=3.3'"),
        ("", True, "/elsewhere/pip", "{home}/bin/python -m pip install 'OpenEXR>=3.3'"),
        ("", False, None, "uv pip install --python {home}/bin/python 'OpenEXR>=3.3'"),
        ("pipx_metadata.json", True, None, "pipx inject strandcli 'OpenEXR>=3.3'"),
        ("EXTERNALLY-MANAGED", True, None, "{home}/bin/python -m pip install --break-system-packages 'OpenEXR>=3.3'"),
    ],
)
def test_the_command_is_that_of_the_installation(
    there: str, pip: bool, which: str | None, command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of an environment; and of a system's Python, which has no prefix of its own, that refuses pip."""
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    monkeypatch.setattr(sys, "base_prefix", str(tmp_path) if there == "EXTERNALLY-MANAGED" else "/usr")
    monkeypatch.setattr(sys, "executable", str(tmp_path / "bin" / "python"))
    monkeypatch.setattr(sysconfig, "get_path", lambda name: str(tmp_path))
    monkeypatch.setattr(extras.shutil, "which", lambda name: which and which.format(home=tmp_path))
    monkeypatch.setattr(extras.importlib.util, "find_spec", lambda name: object() if pip else None)
    if there:
        (tmp_path / there).write_text("")
    assert extras.install("exr") == command.format(home=tmp_path)
