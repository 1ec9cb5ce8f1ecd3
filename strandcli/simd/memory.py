"""Where vectors lie: rows of numbers and heaps of vectors, how they are got, put and fetched."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.cgutils import get_or_insert_function
from numba.core.extending import intrinsic, lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature

from ..constants import VECTOR
from ..jit import device
from .kinds import PointerType, VectorType, places_of, vector_of, widened

FOR_READING, SECOND_CACHE, DATA = 0, 2, 1
"""Arguments of LLVM's prefetch."""


def _address(whole: bool, size: int = VECTOR, fused: bool = False) -> Callable[..., Any]:
    def typed(typingctx: Any, array: Any) -> Any:
        if not (isinstance(array, types.Array) and array.layout == "C"):
            return None

        def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return context.make_array(sig.args[0])(context, builder, value=args[0]).data

        return PointerType(array.dtype, whole, size, fused)(array), emit

    return typed


pointer: Any = intrinsic(_address(False))
"""The numbers of a contiguous array."""
half_width_pointer: Any = intrinsic(_address(False, VECTOR // 2))
"""The same, for vectors of half the length."""
triple_pointer: Any = intrinsic(_address(False, 3 * 4))
"""The same, for vectors of three numbers in single precision."""
quadruple_pointer: Any = intrinsic(_address(False, 4 * 4))
"""The same, for vectors of four numbers of 32 bits."""
vector_pointer: Any = intrinsic(_address(True))
"""The vectors of a contiguous array."""
fused_pointer: Any = intrinsic(_address(False, fused=True))
"""As `pointer`; products in sums are fused."""
fused_vector_pointer: Any = intrinsic(_address(True, fused=True))
"""As `vector_pointer`; products in sums are fused."""


@intrinsic
def fused_pointers(typingctx: Any, arrays: Any) -> Any:
    """A named tuple of contiguous arrays as one of the `fused_pointer` of each."""
    if not isinstance(arrays, types.BaseNamedTuple):
        return None
    form: Any = arrays
    kinds = [PointerType(one.dtype, False, VECTOR, fused=True) for one in form]

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        pairs = zip(sig.args[0], cgutils.unpack_tuple(builder, args[0]), strict=True)
        starts = [context.make_array(kind)(context, builder, value=one).data for kind, one in pairs]
        return context.make_tuple(builder, sig.return_type, starts)

    return types.BaseTuple.from_types(kinds, form.instance_class)(arrays), emit


@intrinsic
def shifted(typingctx: Any, rows: Any, count: Any) -> Any:
    """Pointer to what begins so many vectors later."""
    if not (isinstance(rows, PointerType) and rows.whole and isinstance(count, types.Integer)):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        wide = context.get_value_type(vector_of(sig.args[0])).as_pointer()
        return builder.bitcast(builder.gep(builder.bitcast(args[0], wide), [args[1]]), args[0].type)

    return rows(rows, count), emit


@intrinsic
def array_at(typingctx: Any, kind: Any, address: Any, shape: Any) -> Any:
    """A contiguous array of a type, such as np.float32, and a shape, at an address. Whoever made it keeps it."""
    if not (isinstance(kind, types.NumberClass) and isinstance(address, types.Integer)):
        return None
    made = types.Array(kind.instance_type, len(shape), "C")

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        from numba.np.arrayobj import populate_array  # which kernels of the cache do not need, and imports much

        sizes = [
            context.cast(builder, one, given, types.intp)
            for one, given in zip(cgutils.unpack_tuple(builder, args[2]), sig.args[2], strict=True)
        ]
        array = context.make_array(made)(context, builder)
        place = builder.inttoptr(args[1], context.get_value_type(kind.instance_type).as_pointer())
        width = context.get_abi_sizeof(context.get_data_type(kind.instance_type))
        step = context.get_constant(types.intp, width)
        steps: list[Any] = []
        for one in reversed(sizes):
            steps.insert(0, step)
            step = builder.mul(step, one)
        populate_array(array, place, sizes, steps, width, None)
        return array._getvalue()

    return made(kind, address, shape), emit


@infer_global(operator.getitem)
class _Item(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        if isinstance(args[0], PointerType) and not args[0].whole and isinstance(args[1], types.Integer):
            return signature(args[0].dtype, *args)
        return None


@lower_builtin(operator.getitem, PointerType, types.Integer)
def _item(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return builder.load(builder.gep(args[0], [args[1]]))


def _here(context: Any, builder: Any, kind: PointerType, rows: Any, o: Any) -> Any:
    """Pointer to a vector. Functions that have vectors keep them on their stack, too; LLVM finds out too late to align
    it by itself, and half of them would lie across two cache lines, or not, as the process happens to be loaded."""
    traits = builder.function.attributes
    traits.alignstack = VECTOR
    traits.add("nounwind")  # as all of Numba's are; without any other, llvmlite does not write the alignment
    wide = context.get_value_type(vector_of(kind)).as_pointer()
    if kind.whole:
        return builder.gep(builder.bitcast(rows, wide), [o])
    return builder.bitcast(builder.gep(rows, [o]), wide)


@intrinsic
def load(typingctx: Any, rows: Any, o: Any) -> Any:
    """A vector from place o on."""
    if not (isinstance(rows, PointerType) and isinstance(o, types.Integer)):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.load(_here(context, builder, sig.args[0], *args), align=sig.args[0].dtype.bitwidth // 8)

    return vector_of(rows)(rows, o), emit


@intrinsic
def store(typingctx: Any, rows: Any, o: Any, x: Any) -> Any:
    """Keep a vector from place o on; a plain number in all of its lanes."""
    if not (isinstance(rows, PointerType) and isinstance(o, types.Integer)):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = sig.args[0]
        value = widened(context, builder, args[2], sig.args[2], vector_of(kind))
        builder.store(value, _here(context, builder, kind, *args[:2]), align=kind.dtype.bitwidth // 8)
        return context.get_dummy_value()

    return types.void(rows, o, x), emit


@intrinsic
def gather(typingctx: Any, rows: Any, o: Any, x: Any, stride: Any, y: Any) -> Any:
    """A vector of the numbers at places o + stride * x + y; x: vector of whole numbers, y likewise or one number. What
    is added to o has to be less than 2^31."""
    if not (
        isinstance(rows, PointerType)
        and not rows.whole
        and isinstance(x, VectorType)
        and isinstance(stride, types.Integer)
    ):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind, place = vector_of(sig.args[0]), places_of(context, builder, sig, args)
        wide = context.get_value_type(kind)
        places = builder.gep(builder.gep(args[0], [args[1]]), [ir.Constant(ir.IntType(32), 0)])
        # llvmlite knows of no addresses that are vectors, LLVM does
        places.indices, places.operands = [place], [places.pointer, place]
        places.type = ir.VectorType(args[0].type, wide.count)
        mask = ir.Constant(ir.VectorType(ir.IntType(1), wide.count), [1] * wide.count)
        number = ir.IntType(32)
        typed = ir.FunctionType(wide, [places.type, number, mask.type, wide])
        name = f"llvm.masked.gather.v{wide.count}f{kind.dtype.bitwidth}.v{wide.count}p0"
        gather = get_or_insert_function(builder.module, typed, name)
        size = number(kind.dtype.bitwidth // 8)
        return builder.call(gather, [places, size, mask, ir.Constant(wide, ir.Undefined)])

    return vector_of(rows)(rows, o, x, stride, y), emit


@device
def load3(rows, o, stride):
    """Vectors from places o, o + stride and o + 2 stride on."""
    return load(rows, o), load(rows, o + stride), load(rows, o + 2 * stride)


@device
def store3(rows, o, stride, x, y, z):
    """Keep three vectors so."""
    store(rows, o, x)
    store(rows, o + stride, y)
    store(rows, o + 2 * stride, z)


@intrinsic
def load_deinterleaved(typingctx: Any, rows: Any, o: Any) -> Any:
    """Three vectors, of numbers that take turns from place o on."""
    if not (isinstance(rows, PointerType) and isinstance(o, types.Integer)):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = sig.args[0]
        place = _here(context, builder, kind, *args)
        count = place.type.pointee.count
        every = builder.bitcast(place, ir.VectorType(place.type.pointee.element, 3 * count).as_pointer())
        numbers = builder.load(every, align=kind.dtype.bitwidth // 8)
        turns = ir.VectorType(ir.IntType(32), count)
        out = [
            builder.shuffle_vector(numbers, numbers, ir.Constant(turns, list(range(i, 3 * count, 3)))) for i in range(3)
        ]
        return context.make_tuple(builder, sig.return_type, out)

    return types.UniTuple(vector_of(rows), 3)(rows, o), emit


@intrinsic
def line_pointer(typingctx: Any, array: Any) -> Any:
    """The numbers of a contiguous array from the first on that begins a cache line."""
    if not (isinstance(array, types.Array) and array.layout == "C"):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        data = context.make_array(sig.args[0])(context, builder, value=args[0]).data
        word = ir.IntType(64)
        address = builder.add(builder.ptrtoint(data, word), word(VECTOR - 1))
        return builder.inttoptr(builder.and_(address, word(-VECTOR)), data.type)

    return PointerType(array.dtype, False, VECTOR, fused=False)(array), emit


@intrinsic
def prefetch(typingctx: Any, rows: Any, o: Any) -> Any:
    """Have the processor fetch the cache line of place o, and go on meanwhile."""
    if not (isinstance(rows, PointerType) and isinstance(o, types.Integer)):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        place = builder.bitcast(builder.gep(args[0], [args[1]]), ir.IntType(8).as_pointer())
        number = ir.IntType(32)
        kind = ir.FunctionType(ir.VoidType(), [place.type, number, number, number])
        fetch = get_or_insert_function(builder.module, kind, "llvm.prefetch.p0")
        builder.call(fetch, [place, number(FOR_READING), number(SECOND_CACHE), number(DATA)])
        return context.get_dummy_value()

    return types.void(rows, o), emit


@device
def prefetch3(rows, o, stride):
    """Have three places fetched, o, o + stride and o + 2 stride."""
    prefetch(rows, o)
    prefetch(rows, o + stride)
    prefetch(rows, o + 2 * stride)


@intrinsic
def lane_count(typingctx: Any, rows: Any) -> Any:
    """How many lanes a vector of these rows has."""
    if not isinstance(rows, PointerType):
        return None
    count = vector_of(rows).mask.count
    return types.int64(rows), lambda context, builder, sig, args: context.get_constant(types.int64, count)


@device
def deinterleave(rows, o, count, work, to, stride):
    """So many triples of numbers from place o on into a flat array, from places to, to + stride and to + 2 stride on:
    vectors as far as they go."""
    out = half_width_pointer(work)
    whole = count - count % lane_count(rows)
    for k in range(0, whole, lane_count(rows)):
        x, y, z = load_deinterleaved(rows, o + 3 * k)
        store3(out, to + k, stride, x, y, z)
    for k in range(whole, count):
        work[to + k] = rows[o + 3 * k]
        work[to + k + stride] = rows[o + 3 * k + 1]
        work[to + k + 2 * stride] = rows[o + 3 * k + 2]
