"""Signs and functions that Python has, of vectors: sums, products, comparisons, masks."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.extending import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature

from .kinds import Mask, VectorType, call_of, widened


def _define(
    function: Callable[..., Any], emit: Callable[..., Any], count: int, compares: bool = False, fused: Any = None
) -> None:
    """Teach Numba what a Python function is of vectors, or of vectors and numbers; ``fused`` is what is emitted for
    those that are, where the processor has that."""

    class Template(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            wide = [one for one in args if isinstance(one, VectorType)]
            fits = len(args) == count and all(isinstance(one, (VectorType, types.Number)) for one in args)
            if fits and wide and all(isinstance(one.dtype, types.Float) for one in wide):
                return signature(wide[0].mask if compares else wide[0], *args)
            return None

    infer_global(function)(Template)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = next(one for one in sig.args if isinstance(one, VectorType))
        wide = (widened(context, builder, v, t, kind) for v, t in zip(args, sig.args, strict=True))
        return (fused if fused is not None and kind.fused and has_fma(context) else emit)(builder, *wide)

    kinds = (
        [(VectorType,)]
        if count == 1
        else [(VectorType, VectorType), (VectorType, types.Number), (types.Number, VectorType)]
    )
    for kind in kinds:
        lower_builtin(function, *kind)(lower)


def _either(sign: str) -> Callable[..., Any]:
    return lambda b, x, y: b.select(b.fcmp_ordered(sign, y, x), y, x)


def has_fma(context: Any) -> bool:
    """Whether the processor that is compiled for multiplies and adds in one operation, as all do since 2013."""
    machine, _, features = context.codegen().magic_tuple()
    return machine.startswith(("aarch64", "arm64")) or "+fma" in features.split(",")


def _factors(x: Any) -> list[Any]:
    """Of what is a product, else nothing."""
    return x.operands if isinstance(x, ir.Instruction) and x.opname == "fmul" else []


_fuse = call_of("llvm.fma", 3)


def _fused_sum(b: Any, x: Any, y: Any) -> Any:
    """x + y, of two products the second one not rounded."""
    if _factors(y):
        return _fuse(b, *_factors(y), x)
    return _fuse(b, *_factors(x), y) if _factors(x) else b.fadd(x, y)


def _fused_difference(b: Any, x: Any, y: Any) -> Any:
    """x - y, likewise."""
    if _factors(y):
        first, second = _factors(y)
        return _fuse(b, b.fneg(first), second, x)
    return _fuse(b, *_factors(x), b.fneg(y)) if _factors(x) else b.fsub(x, y)


for _functions, _emit, _fused in (
    ((operator.add, operator.iadd), lambda b, x, y: b.fadd(x, y), _fused_sum),
    ((operator.sub, operator.isub), lambda b, x, y: b.fsub(x, y), _fused_difference),
    ((operator.mul, operator.imul), lambda b, x, y: b.fmul(x, y), None),
    ((operator.truediv, operator.itruediv), lambda b, x, y: b.fdiv(x, y), None),
    ((max,), _either(">"), None),
    ((min,), _either("<"), None),
):
    for _function in _functions:
        _define(_function, _emit, 2, fused=_fused)
_SIGNS = {operator.lt: "<", operator.le: "<=", operator.gt: ">", operator.ge: ">="}
for _function, _sign in _SIGNS.items():
    _define(_function, lambda b, x, y, _sign=_sign: b.fcmp_ordered(_sign, x, y), 2, compares=True)
_define(operator.ne, lambda b, x, y: b.fcmp_unordered("!=", x, y), 2, compares=True)
_define(operator.neg, lambda b, x: b.fneg(x), 1)
_define(abs, call_of("llvm.fabs"), 1)


def _join(function: Callable[..., Any], emit: Callable[..., Any], count: int) -> None:
    class Template(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            same = len(args) == count and isinstance(args[0], Mask) and len(set(args)) == 1
            return signature(args[0], *args) if same else None

    infer_global(function)(Template)
    lower_builtin(function, *(Mask,) * count)(lambda context, builder, sig, args: emit(builder, *args))


_join(operator.and_, lambda b, x, y: b.and_(x, y), 2)
_join(operator.or_, lambda b, x, y: b.or_(x, y), 2)
_join(operator.invert, lambda b, x: b.xor(x, ir.Constant(x.type, [1] * x.type.count)), 1)
