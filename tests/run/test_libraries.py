"""Memory that libraries' files take: read of the system, kept for each environment, reckoned with by plans."""

from __future__ import annotations

import platform
import subprocess
import sys
from pathlib import Path

import pytest

from strand_kit import scene_of
from strandcli.compiling.folder import cache
from strandcli.plan import libraries, make_plan


@pytest.mark.parametrize("content", ["", "[]", "{", '{"a": "x"}', '{"a": 1}'])
def test_plans_reckon_with_what_was_kept(content: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cache, "_path", tmp_path)
    monkeypatch.setattr(libraries._Known, "bytes", libraries.USUAL)
    scene = scene_of("emitter: {strands: 10, particles: 3}")
    before = make_plan(scene, [1]).memory_bytes
    (tmp_path / libraries.FILE).write_text(content)
    libraries.look()
    assert make_plan(scene, [1]).memory_bytes == before
    libraries.keep(1)  # not to be believed
    libraries.keep(libraries.USUAL + 7_000_000)
    libraries.look()
    assert make_plan(scene, [1]).memory_bytes == before + 7_000_000
    for no_news in (libraries.USUAL + 7_500_000, libraries.USUAL):
        libraries.keep(no_news)
        assert libraries._kept() == {libraries._environment(): libraries.USUAL + 7_000_000}
    libraries.keep(libraries.USUAL - 13_000_000)  # a quarter of the way, for pages may have been taken back
    assert libraries._kept() == {libraries._environment(): libraries.USUAL + 2_000_000}
    libraries.keep(libraries.USUAL + 9_000_000)
    assert libraries._kept() == {libraries._environment(): libraries.USUAL + 9_000_000}


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
