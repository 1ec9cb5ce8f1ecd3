"""Kernels of one line, and what tests of their cache share: to call one and to choose the folder as a new process."""

from __future__ import annotations

from typing import Any

import pytest

from strandcli import doctor
from strandcli.compiling import folder
from strandcli.jit import function
from strandcli.jit.dispatcher import KernelDispatcher


@function
def plus_one(x):  # type: ignore[no-untyped-def]
    return x + 1


@function
def plus_two(x):  # type: ignore[no-untyped-def]
    return x + 2


@function
def plus_three(x):  # type: ignore[no-untyped-def]
    return x + 3


def fresh(kernel: Any) -> KernelDispatcher:
    """The kernel as a process that has not called it yet has it."""
    return KernelDispatcher(kernel.py_func, kernel._cache._options)


def hits(kernel: Any) -> int:
    """How many of its signatures came from the cache."""
    return sum(kernel.stats.cache_hits.values())


def called(kernel: Any = plus_one) -> bool:
    """Call it as a new process does; return whether it came from the cache."""
    new = fresh(kernel)
    assert new(1) == kernel.py_func(1)
    return hits(new) == 1


def begin(monkeypatch: pytest.MonkeyPatch) -> folder.Folder:
    """Choose the folder anew, as another process would."""
    new = folder.Folder()
    for module in (folder, doctor):
        monkeypatch.setattr(module, "cache", new)
    return new
