"""Settings of Numba's: those with which nothing can be drawn are refused, and arithmetic has no shortcuts."""

from __future__ import annotations

import numba
import pytest

from cli_runs import Runner
from strandcli.draw.zbuffer.kernels import lines, raster


def test_a_run_without_numbas_compiler_is_refused_in_one_line(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "DISABLE_JIT", 1)
    done = run("render", "tiny.yaml", "-f", "1", "-o", "a")
    assert done.code == 2
    assert "NUMBA_DISABLE_JIT is set" in done.error()
    assert "unset it" in done.error()


def test_kernels_are_compiled_without_shortcuts_in_arithmetic() -> None:
    """Fast maths would let pictures depend on the machine and on the number of threads."""
    for kernel in (lines.draw_line, raster.draw_strands):
        options = kernel.targetoptions
        assert not options.get("fastmath", False)
        assert options["error_model"] == "numpy"
        assert options["nogil"]
    assert raster.draw_strands.targetoptions["parallel"]
