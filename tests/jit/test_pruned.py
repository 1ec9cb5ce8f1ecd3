"""What a type of argument does not need is not compiled; kernels from the cache need no dispatcher."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import TypingError, float64, njit

from strandcli.jit import device, inlined
from strandcli.jit.pruned import device_where


class Whole(NamedTuple):
    numbers: Any


class Bare(Whole):
    needed = False


def is_needed(one: Any) -> bool:
    return bool(getattr(one.instance_class, "needed", True))


@device_where(is_needed, lambda one, factor: -1.0)
def total(one, factor):  # type: ignore[no-untyped-def]
    return factor * one.numbers.sum()


@device_where(is_needed, lambda one: 0.0)
def cannot_be_compiled(one):  # type: ignore[no-untyped-def]
    return one.no_such_field


@njit
def call_total(one: Any) -> Any:
    return total(one, 2.0)


@njit
def call_broken(one: Any) -> Any:
    return cannot_be_compiled(one)


NUMBERS = np.array([1.0, 2.0])


def test_the_function_stands_where_it_is_needed_and_the_other_elsewhere() -> None:
    assert call_total(Whole(NUMBERS)) == 6.0
    assert call_total(Bare(NUMBERS)) == -1.0


def test_what_is_not_needed_is_not_even_typed() -> None:
    assert call_broken(Bare(NUMBERS)) == 0.0
    with pytest.raises(TypingError, match="no_such_field"):
        call_broken(Whole(NUMBERS))


def leaf(x: Any) -> Any:
    return 2.0 * x + 1.0


@pytest.mark.parametrize(("how", "forced"), [(device, False), (inlined, True)], ids=["device", "inlined"])
def test_a_function_does_not_inherit_forced_inlining_from_its_caller(how: Any, forced: bool) -> None:
    callee = how(leaf)

    @inlined
    def middle(x: Any) -> Any:
        return callee(x)

    @njit
    def outer(x: Any) -> Any:
        return middle(x)

    assert outer(3.0) == 7.0
    assert callee.overloads[(float64,)].signature.args == (float64,)
    assert ("alwaysinline" in callee.inspect_llvm((float64,))) is forced


def test_a_draw_from_the_cache_makes_none_and_does_not_import_what_the_compiler_needs(tmp_path: Path) -> None:
    program = (
        "import sys\n"
        "from strandcli.cli.main import main\n"
        "assert main(sys.argv[1:]) == 0\n"
        "from strandcli.jit.dispatcher import Deferred\n"
        "there = [one for name, module in list(sys.modules.items()) if name.startswith('strandcli.')\n"
        "         for one in vars(module).values() if isinstance(one, Deferred)]\n"
        "print(len(there), sum(one._made is not None for one in there), 'numba.np.arrayobj' in sys.modules)\n"
    )
    words = "render minimal -f 1 --size 32x24 --quiet --overwrite -o"
    for _ in range(2):  # the first may compile
        command = [sys.executable, "-c", program, *words.split(), str(tmp_path / "out")]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    count, made, imported = done.stdout.split()
    assert int(count) > 300
    assert (made, imported) == ("0", "False")
