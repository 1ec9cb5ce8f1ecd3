"""Other people's Numba code in the same process: it computes what it computes without strandcli, and Numba, the
environment and the process are left as they were found."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from numba import config

PROGRAM = Path(__file__).with_name("strangers_program.py")


def run(mode: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """What the program prints."""
    place = {**os.environ, "PYTHONPATH": str(PROGRAM.parents[2]), "PYTHONWARNINGS": "ignore", **environment}
    done = subprocess.run([sys.executable, str(PROGRAM), mode], env=place, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done


@pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")  # type: ignore[attr-defined]
def test_strangers_compute_the_same_after_a_render_and_nothing_of_numba_has_changed() -> None:
    alone, rendered = run("plain"), run("rendered")
    assert rendered.stdout == alone.stdout
    assert rendered.stderr == ""


def test_nothing_changes_where_kernels_are_compiled_in_place(tmp_path: Path) -> None:
    """With an empty cache and without workers."""
    done = run("simulated", STRANDCLI_COMPILERS="0", STRANDCLI_CACHE_DIR=str(tmp_path / "cache"))
    assert done.stderr == ""
