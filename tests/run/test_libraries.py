"""What libraries are told in a process of our own: threads that wait sleep, and memory goes back."""

from __future__ import annotations

import platform
import subprocess
import sys
from pathlib import Path

import pytest


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
