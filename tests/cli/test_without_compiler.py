"""Kernels where NUMBA_DISABLE_JIT is set."""

from __future__ import annotations

import numba
import pytest

from strandcli.cli import main as module


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
