"""What is done lane by lane, and what is asked of all lanes together."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.extending import intrinsic

from .kinds import Mask, PointerType, VectorType, call_of, vector_of, widened

SINGLE, EXPONENT_BIAS, MANTISSA_BITS = 32, 127, 23
"""Bits of a number in single precision, what is added to its exponent, and bits below that."""


@intrinsic
def where(typingctx: Any, mask: Any, x: Any, y: Any) -> Any:
    """x in lanes where the mask holds, else y."""
    wide = [one for one in (x, y) if isinstance(one, VectorType)]
    if not isinstance(mask, Mask) or not wide:
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = sig.return_type
        first, second = (widened(context, builder, v, t, kind) for v, t in zip(args[1:], sig.args[1:], strict=True))
        return builder.select(args[0], first, second)

    return wide[0](mask, x, y), emit


@intrinsic
def any_lane(typingctx: Any, mask: Any) -> Any:
    """Whether a mask holds in any lane."""
    if not isinstance(mask, Mask):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = ir.IntType(sig.args[0].count)
        return builder.icmp_unsigned("!=", builder.bitcast(args[0], kind), ir.Constant(kind, 0))

    return types.boolean(mask), emit


@intrinsic
def movemask(typingctx: Any, mask: Any) -> Any:
    """The lanes in which a mask holds, as bits of a number, the first the lowest."""
    if not isinstance(mask, Mask):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        bits = builder.bitcast(args[0], ir.IntType(sig.args[0].count))
        return builder.zext(bits, context.get_value_type(sig.return_type))

    return types.uint64(mask), emit


def _of_each(function: str, doc: str) -> Any:
    """An LLVM function of each lane."""
    call = call_of(function)

    def typed(typingctx: Any, x: Any) -> Any:
        if not isinstance(x, VectorType):
            return None
        return x(x), lambda context, builder, sig, args: call(builder, *args)

    typed.__doc__ = doc
    return intrinsic(typed)


sqrt = _of_each("llvm.sqrt", "Square root.")
floor = _of_each("llvm.floor", "The greatest whole number that is no greater.")


@intrinsic
def power_of_two(typingctx: Any, x: Any) -> Any:
    """2 to the power of whole numbers from −126 to 127, in single precision."""
    if not (isinstance(x, VectorType) and x.dtype.bitwidth == SINGLE):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        whole = ir.VectorType(ir.IntType(SINGLE), args[0].type.count)
        biased = builder.add(builder.fptosi(args[0], whole), ir.Constant(whole, [EXPONENT_BIAS] * whole.count))
        return builder.bitcast(builder.shl(biased, ir.Constant(whole, [MANTISSA_BITS] * whole.count)), args[0].type)

    return x(x), emit


@intrinsic
def no_fma(typingctx: Any, x: Any) -> Any:
    """A product as a number of its own, which is not fused."""
    if not isinstance(x, VectorType):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = args[0].type
        return builder.fadd(args[0], ir.Constant(kind, [-0.0] * kind.count))  # which changes no number

    return x(x), emit


@intrinsic
def reduce_max(typingctx: Any, x: Any) -> Any:
    """The greatest number of all lanes, none of which is NaN."""
    if not isinstance(x, VectorType):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        lane = ir.IntType(32)
        most = builder.extract_element(args[0], ir.Constant(lane, 0))
        for i in range(1, args[0].type.count):
            one = builder.extract_element(args[0], ir.Constant(lane, i))
            most = builder.select(builder.fcmp_ordered(">", one, most), one, most)
        return most

    return x.dtype(x), emit


@intrinsic
def broadcast(typingctx: Any, like: Any, x: Any) -> Any:
    """The number x in all lanes of a vector, of the kind of numbers that rows or a vector ``like`` hold."""
    if not (isinstance(like, (PointerType, VectorType)) and isinstance(x, types.Number)):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return widened(context, builder, args[1], sig.args[1], sig.return_type)

    return vector_of(like)(like, x), emit


@intrinsic
def lane(typingctx: Any, x: Any, k: Any) -> Any:
    """The number in one lane."""
    if not (isinstance(x, VectorType) and isinstance(k, types.Integer)):
        return None
    return x.dtype(x, k), lambda context, builder, sig, args: builder.extract_element(args[0], args[1])


@intrinsic
def with_lane(typingctx: Any, x: Any, k: Any, number: Any) -> Any:
    """A vector with another number in one lane."""
    if not (isinstance(x, VectorType) and isinstance(k, types.Integer) and isinstance(number, types.Float)):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        one = context.cast(builder, args[2], sig.args[2], x.dtype)
        return builder.insert_element(args[0], one, args[1])

    return x(x, k, number), emit


@intrinsic
def bits_of_places(typingctx: Any, begin: Any, x: Any, stride: Any, y: Any) -> Any:
    """The bits of the whole numbers begin + stride * x + y, of 32 bits, as a vector in single precision that may be
    stored and no more; x and y: vectors of whole numbers."""
    vectors = isinstance(x, VectorType) and isinstance(y, VectorType) and x.dtype.bitwidth == SINGLE
    if not (vectors and isinstance(begin, types.Integer) and isinstance(stride, types.Integer)):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        count = args[1].type.count
        whole = ir.VectorType(ir.IntType(SINGLE), count)
        none, same = ir.Constant(whole, ir.Undefined), ir.Constant(whole, None)

        def spread(k: int) -> Any:
            number = context.cast(builder, args[k], sig.args[k], types.int32)
            first = builder.insert_element(none, number, ir.Constant(ir.IntType(SINGLE), 0))
            return builder.shuffle_vector(first, none, same)

        product = builder.mul(builder.fptosi(args[1], whole), spread(2))
        places = builder.add(builder.add(product, builder.fptosi(args[3], whole)), spread(0))
        return builder.bitcast(places, args[1].type)

    return x(begin, x, stride, y), emit
