"""Functions that only kernels call have no dispatcher until one is compiled; kernels from the cache need none."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

from numba.core import environment

from strandcli.jit import device, function, loaded
from strandcli.jit.deferred import Deferred


@device
def twice(x):
    """Two times x."""
    return 2 * x


@device
def factorial(n):
    """n!"""
    if n < 2:
        return 1
    return n * factorial(n - 1)


@function
def of_both(x, n):
    return twice(x) + factorial(n)


def test_a_dispatcher_is_made_once_and_when_a_kernel_is_compiled() -> None:
    assert isinstance(twice, Deferred)
    assert (twice.__name__, twice.__doc__, twice.py_func(3)) == ("twice", "Two times x.", 6)
    of_both.py_func.__globals__["twice"] = fresh = device(twice.py_func)
    assert fresh._made is None
    kernel: Any = function(of_both.py_func)
    kernel._cache.load_overload = lambda *given: None  # as where the cache has none
    kernel._cache.save_overload = lambda *given: None
    assert kernel(4, 5) == 8 + 120
    assert len(fresh._made.overloads) == 1
    assert fresh._numba_type_ is fresh._made._numba_type_
    assert fresh.targetoptions["error_model"] == "numpy"
    assert device(twice.py_func)._made is None


def test_a_draw_from_the_cache_makes_none_and_does_not_import_what_the_compiler_needs(tmp_path: Path) -> None:
    program = (
        "import sys\n"
        "from strandcli.cli.main import main\n"
        "assert main(sys.argv[1:]) == 0\n"
        "from strandcli.jit.deferred import Deferred\n"
        "there = [one for name, module in list(sys.modules.items()) if name.startswith('strandcli.')\n"
        "         for one in vars(module).values() if isinstance(one, Deferred)]\n"
        "print(len(there), sum(one._made is not None for one in there), 'numba.np.arrayobj' in sys.modules)\n"
    )
    arguments = [
        "render",
        "minimal",
        "-f",
        "1",
        "--size",
        "32x24",
        "--quiet",
        "--overwrite",
        "-o",
        str(tmp_path / "out"),
    ]
    for _ in range(2):  # the first may compile
        command = [sys.executable, "-c", program, *arguments]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    count, made, imported = done.stdout.split()
    assert int(count) > 300
    assert (made, imported) == ("0", "False")


def test_of_a_module_that_nobody_has_imported_an_environment_has_constants_and_stays_the_kernels_own() -> None:
    made = loaded._environment("no.such.module", ("one", 2), "a name of its own")
    assert (made.consts, made.env_name, made.can_cache()) == (["one", 2], "a name of its own", True)
    assert environment.lookup_environment("a name of its own") is None
    shared = loaded._environment(__name__, (), "a name of this module's")
    assert shared.globals is globals()
    assert environment.lookup_environment("a name of this module's") is shared
