"""Numba spared double work: the same code comes out, and nothing is left changed when a kernel is compiled."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from numba import config, typeof
from numba.core import ir
from numba.core.compiler import Flags, run_frontend

from strandcli import runtime
from strandcli.compiler import TESTED
from strandcli.jit import device, function, parallel, prange

pytestmark = [
    pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled"),
    pytest.mark.skipif(numba.__version__.rpartition(".")[0] not in TESTED, reason="a version that is left as it is"),
]


@device
def mixed(x, i):
    """Integers and floats of two widths, literals among them: each operator with types of its own."""
    whole = i + i * 2
    return x + x * np.float32(2) + np.float32(whole) + np.float32(i / 2) + np.float32(1 + 1)


@parallel
def mix(values, out):
    for i in prange(values.shape[0]):
        out[i] = mixed(values[i], np.int64(i))


@function
def strict(n):
    if n < 0:
        raise ValueError("less than nothing")
    return n


@device
def refused(n):
    if n > 9:
        raise ValueError("too many")
    return strict(n)


@function
def ask(n):
    return refused(n) + 1


def test_a_kernel_holds_its_parts_which_have_no_machine_code_of_their_own() -> None:
    values = np.linspace(0, 1, 7, dtype=np.float32)
    out = np.zeros(7, np.float32)
    mix(values, out)
    i = np.arange(7)
    np.testing.assert_allclose(out, 3 * values + 3 * i + i / 2 + 2, rtol=1e-6)

    mixed.compile((typeof(values[0]), typeof(7)))  # where the kernel came from the cache it has not been

    def emitted(dispatcher: Any) -> list[bool]:
        engine = runtime_engine()
        return [engine.is_symbol_defined(one.fndesc.llvm_func_name) for one in dispatcher.overloads.values()]

    assert emitted(mix) == [True]
    assert emitted(mixed) == [False]
    if runtime.shared_folder() is not None:
        kept = {path.name.split("-")[0] for path in runtime.cache_folder().rglob("test_compiler.*.nbi")}
        assert "test_compiler.mix" in kept
        assert "test_compiler.mixed" not in kept


def runtime_engine() -> Any:
    from numba.core.registry import cpu_target

    return cpu_target.target_context.codegen()._engine


def test_errors_raised_in_a_part_arrive_in_python() -> None:
    assert ask(3) == 4
    with pytest.raises(ValueError, match="too many"):
        ask(10)
    with pytest.raises(ValueError, match="less than nothing"):
        ask(-1)
    with pytest.raises(ValueError, match="less than nothing"):
        strict(-1)


def test_a_loop_is_optimised_by_itself_and_not_again_in_its_kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    from numba.core.codegen import CPUCodeLibrary

    @numba.njit(parallel=True, nogil=True, error_model="numpy", no_cfunc_wrapper=True)  # `parallel`, never cached
    def doubled(values, out):
        for i in prange(values.shape[0]):
            out[i] = values[i] + values[i]

    bodies: dict[str, list[int]] = {}  # by the name of what is optimised how many loops are in it
    optimise = CPUCodeLibrary._optimize_final_module

    def watched(self: Any) -> None:
        bodies.setdefault(self.name.split("(")[0], []).append(loops(self))
        optimise(self)

    def loops(library: Any) -> int:
        return sum("parfor_gufunc" in one.name and not one.is_declaration for one in library._final_module.functions)

    monkeypatch.setattr(CPUCodeLibrary, "_optimize_final_module", watched)
    values = np.arange(5, dtype=np.float64)
    out = np.zeros(5)
    doubled(values, out)
    np.testing.assert_array_equal(out, 2 * values)
    of_kernel = [found for name, found in bodies.items() if "doubled" in name]
    assert of_kernel == [[0]]
    of_loop = [found for name, found in bodies.items() if name.startswith("__numba_parfor_gufunc")]
    assert len(of_loop) == 1
    assert of_loop[0][0] > 0


def test_generators_and_python_objects_know_which_variables_live() -> None:
    @numba.njit
    def counted(n):
        total = 0
        for i in range(n):
            total += i
            yield total

    @numba.jit(forceobj=True, looplift=False)
    def joined(words):
        text = ""
        for word in words:
            if word:
                text = text + word
        return text

    assert list(counted(5)) == [0, 1, 3, 6, 10]
    assert joined(["a", "", "b"]) == "ab"


def test_copies_are_apart_from_what_they_were_made_of() -> None:
    from numba.core import ir_utils

    for original in ({1: {"a"}, 2: set()}, {1: ["a"]}, [{"a"}]):
        copied = ir_utils.copy.deepcopy(original)
        assert copied == original
        inside, inside_copy = (list(one.values()) if isinstance(one, dict) else one for one in (original, copied))
        assert all(a is not b for a, b in zip(inside, inside_copy, strict=True))


def test_settings_are_equal_where_all_of_them_are() -> None:
    flags, other = Flags(), Flags()
    assert flags == other
    other.nrt = not flags.nrt
    assert flags != other
    assert hash(flags) == hash(other)  # they may become equal
    other.nrt = flags.nrt  # set, to what it is anyway
    assert flags == other
    flags.nrt, other.nrt = True, False
    assert flags != other
    assert flags != 3


def names(value: Any) -> Iterator[str]:
    """Variables in a statement, read plainly."""
    if isinstance(value, ir.Var):
        yield value.name
    elif isinstance(value, ir.Expr):
        yield from names(value._kws)
    elif isinstance(value, ir.Inst):
        yield from names(value.__dict__)
    elif isinstance(value, list | tuple | dict):
        for part in value.values() if isinstance(value, dict) else value:
            yield from names(part)


def test_all_variables_of_a_statement_are_listed() -> None:
    def subject(a, b, *rest):
        pair = (a, b)
        a[0:2] = b[1]
        for i in range(3):
            if i > b[0]:
                return max(a[i], b[i], key=rest)
        return {"pair": pair, "a": [a, b]}

    statements = [one for block in run_frontend(subject).blocks.values() for one in block.body]
    listed = [[variable.name for variable in one.list_vars()] for one in statements]
    assert listed == [list(names(one)) for one in statements]
    assert max(len(one) for one in listed) > 3


def test_nothing_is_left_changed() -> None:
    from llvmlite.binding import ffi

    before = gc.get_threshold(), list(ffi.lib._lock._cblist)
    assert before[1]

    @device
    def twice(x):
        return x + x

    @function
    def again(x):
        return twice(x)

    @function
    def wrong(x):
        return x.nothing

    assert again(2) == 4
    with pytest.raises(Exception, match="nothing"):
        wrong(2)
    assert (gc.get_threshold(), list(ffi.lib._lock._cblist)) == before


CALLED_FROM_BOTH = """
import sys
import numpy as np
from strandcli.draw.coverage.kernels import tiles
from strandcli.jit import function, inner

@inner
def part(t, past, bits):
    return tiles.fixed(t, past, bits) + 1

@function
def whole(t, past, bits):
    return part(t, past, bits) * 2

if "kernel first" in sys.argv:
    assert whole(np.float32(0.3), 1, 10) == 2664
assert tiles.fixed(np.float32(0.3), 1, 10) == 1331
"""


def test_what_a_part_takes_from_the_cache_python_may_call_as_well(tmp_path: Path) -> None:
    script = tmp_path / "both.py"
    script.write_text(CALLED_FROM_BOTH)
    place = {**os.environ, "STRANDCLI_CACHE_DIR": str(tmp_path / "cache"),
    "PYTHONPATH": str(Path(__file__).resolve().parents[2])}
    for words in ([], ["kernel first"]):  # the first run fills the cache
        done = subprocess.run([sys.executable, script, *words], env=place, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
