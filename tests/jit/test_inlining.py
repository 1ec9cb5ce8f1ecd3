"""Only what says so is part of its caller, whoever has it compiled first."""

from typing import Any

import pytest
from numba import float64, njit

from strandcli.jit import device, inlined


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
