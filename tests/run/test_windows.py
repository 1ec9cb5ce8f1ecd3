"""What Windows lacks is asked for by nobody: a run without these modules, signals and flags."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from cli_runs import TINY, environment

CODE = """
import os, signal, sys
import numba, numpy, PIL.Image, subprocess  # which have their own ways
for name in ("fcntl", "resource", "termios", "pwd", "grp"):
    sys.modules[name] = None
delattr(signal, "SIGHUP")
for name in ("O_NONBLOCK", "O_CLOEXEC", "sched_getaffinity", "getuid"):
    delattr(os, name)
from strandcli.cli.main import main
for words in (["render", "tiny.yaml", "-f", "1-2", "-o", "a"], ["simulate", "tiny.yaml", "-f", "1", "-o", "b"]):
    code = main(words)
    if code:
        sys.exit(code)
"""


def test_a_run_needs_nothing_that_windows_lacks(tmp_path: Path) -> None:
    (tmp_path / "tiny.yaml").write_text(TINY)
    told = {**environment(), "STRANDCLI_COMPILERS": "0"}
    done = subprocess.run([sys.executable, "-c", CODE], cwd=tmp_path, env=told, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "a/report.html").exists()
    assert (tmp_path / "b/manifest.json").exists()
