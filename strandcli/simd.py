"""Numbers of several strands at once as a type of Numba's own: one LLVM vector, which lives in registers.

Kernels that work a row of lanes at a time through memory depend on what LLVM's loop vectoriser happens to see, and on a
cache that holds all rows. With this type a kernel is written for one strand, moves `VECTOR` bytes' worth of them, and
vectorises always; a vector that is wider than the machine's registers takes several.

    rows = lay(array)           the numbers of a contiguous array of any shape, one after the other
    rows = strip(array)         the same, and vectors of half as many: where most loops are short
    rows = three(array)         the same, and vectors of three numbers in single precision
    pile = heap(array)          the vectors of a contiguous array: place 1 is that of the second vector
    rows = lay_at(np.float32, a); pile = heap_at(np.float32, a)   the same of numbers that begin at an address; these
                                are fused
    rows[o]                     a number
    width(rows)                 how many of them are a vector
    x = get(rows, o)            a vector from place o on
    pick(rows, o, x, stride, y) a vector of the numbers at places o + stride * x + y, where x and y are whole
    put(rows, o, x)
    x, y, z = get3(rows, o, stride); put3(rows, o, stride, x, y, z)
    x, y, z = deal(rows, o)     vectors of every third number from places o, o + 1 and o + 2 on
    deal_out(rows, o, count, work, to, stride)      the same of so many triples, into an array
    x + y, x - 1.0, -x, x * y, x / y, abs(x), max(x, y), min(x, y), root(x), whole(x), sine(x), cosine(x)
    where(x < y, a, b)          lane by lane, also for !=; masks are joined with &, | and ~
    some(x < y)                 whether it holds in any lane
    pattern(x < y)              in which, as bits of a number, the first the lowest
    tally(x < y)                in how many
    greatest(x), spread(x, 2.0)
    rounded(x * y) + z          the product is rounded, where it would be fused
    ask3(rows, o, stride)       has the processor fetch what `get3` is going to read; a place that is none does no harm

Whole numbers can be got and put, and no more. Numbers that are not vectors stand for lanes that are all equal. max and
min return their first argument where one is NaN that comes second, as Numba's do. Rows are no more than an address:
handing them on costs nothing, where an array's references are counted, and who calls keeps the array. Places are not
checked, and arithmetic is IEEE 754's, so that bits are those of scalars.

Vectors of numbers at an address are fused: a product that is added or subtracted where it is written is not rounded
before, as IEEE 754's fusedMultiplyAdd, of two products the second. That is one operation where it was two, and which
products it is, is settled here and not by LLVM: bits are the same on all processors that have it.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.cgutils import get_or_insert_function
from numba.core.datamodel import models
from numba.core.extending import intrinsic, lower_builtin, register_model
from numba.core.typing.templates import AbstractTemplate, infer_global, signature

from .constants import VECTOR
from .jit import inner

FOR_READING, SECOND_CACHE, DATA = 0, 2, 1
"""What LLVM's prefetch is told."""


class Lanes(types.Type):
    """A vector of numbers, ``size`` bytes of them; ``fused``: products that are terms of a sum are not rounded."""

    def __init__(self, dtype: Any, size: int, fused: bool) -> None:
        self.dtype, self.size, self.fused = dtype, size, fused
        self.mask = Mask(size * 8 // dtype.bitwidth)
        super().__init__(f"{'Fused' * fused}Lanes({dtype}, {size})")


class Mask(types.Type):
    """A vector of truth values."""

    def __init__(self, count: int) -> None:
        self.count = count
        super().__init__(f"Mask({count})")


class Rows(types.Type):
    """Numbers in memory, or vectors of them where ``whole``; vectors have ``size`` bytes, and are ``fused`` or not."""

    def __init__(self, dtype: Any, whole: bool, size: int, fused: bool) -> None:
        self.dtype, self.whole, self.size, self.fused = dtype, whole, size, fused
        super().__init__(f"{'Fused' * fused}{'Heap' if whole else 'Rows'}({dtype}, {size})")


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Lanes) -> None:
        super().__init__(manager, kind, ir.VectorType(manager.lookup(kind.dtype).get_value_type(), kind.mask.count))


@register_model(Mask)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Mask) -> None:
        super().__init__(manager, kind, ir.VectorType(ir.IntType(1), kind.count))


@register_model(Rows)
class _RowsModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Rows) -> None:
        super().__init__(manager, kind, manager.lookup(kind.dtype).get_value_type().as_pointer())


def _wide(context: Any, builder: Any, value: Any, given: Any, kind: Lanes) -> Any:
    """A lowered argument as a vector of this kind; a number goes to all lanes."""
    if isinstance(given, Lanes):
        return value
    value = context.cast(builder, value, given, kind.dtype)
    wide = context.get_value_type(kind)
    none = ir.Constant(wide, ir.Undefined)
    first = builder.insert_element(none, value, ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(first, none, ir.Constant(ir.VectorType(ir.IntType(32), wide.count), None))


def _define(
    function: Callable[..., Any], emit: Callable[..., Any], count: int, compares: bool = False, fused: Any = None
) -> None:
    """Teach Numba what a Python function is of vectors, or of vectors and numbers; ``fused`` is what is emitted for
    those that are, where the processor has that."""

    class Template(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            wide = [one for one in args if isinstance(one, Lanes)]
            fits = len(args) == count and all(isinstance(one, (Lanes, types.Number)) for one in args)
            if fits and wide and all(isinstance(one.dtype, types.Float) for one in wide):
                return signature(wide[0].mask if compares else wide[0], *args)
            return None

    infer_global(function)(Template)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = next(one for one in sig.args if isinstance(one, Lanes))
        wide = (_wide(context, builder, v, t, kind) for v, t in zip(args, sig.args, strict=True))
        return (fused if fused is not None and kind.fused and fuses(context) else emit)(builder, *wide)

    kinds = [(Lanes,)] if count == 1 else [(Lanes, Lanes), (Lanes, types.Number), (types.Number, Lanes)]
    for kind in kinds:
        lower_builtin(function, *kind)(lower)


def _either(sign: str) -> Callable[..., Any]:
    return lambda b, x, y: b.select(b.fcmp_ordered(sign, y, x), y, x)


def fuses(context: Any) -> bool:
    """Whether the processor that is compiled for multiplies and adds in one operation, as all do since 2013."""
    machine, _, features = context.codegen().magic_tuple()
    return machine.startswith(("aarch64", "arm64")) or "+fma" in features.split(",")


def _factors(x: Any) -> list[Any]:
    """Of what is a product, else nothing."""
    return x.operands if isinstance(x, ir.Instruction) and x.opname == "fmul" else []


def _call(name: str, count: int = 1) -> Callable[..., Any]:
    """What LLVM has by a name, of so many vectors."""

    def emit(builder: Any, *args: Any) -> Any:
        wide = args[0].type
        width = "f32" if wide.element == ir.FloatType() else "f64"
        kind = ir.FunctionType(wide, [wide] * count)
        return builder.call(get_or_insert_function(builder.module, kind, f"{name}.v{wide.count}{width}"), args)

    return emit


_fuse = _call("llvm.fma", 3)


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
_define(abs, _call("llvm.fabs"), 1)


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


def _address(whole: bool, size: int = VECTOR) -> Callable[..., Any]:
    def typed(typingctx: Any, array: Any) -> Any:
        if not (isinstance(array, types.Array) and array.layout == "C"):
            return None

        def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return context.make_array(sig.args[0])(context, builder, value=args[0]).data

        return Rows(array.dtype, whole, size, fused=False)(array), emit

    return typed


lay: Any = intrinsic(_address(False))
"""The numbers of a contiguous array."""
strip: Any = intrinsic(_address(False, VECTOR // 2))
"""The same, for vectors of half the length."""
three: Any = intrinsic(_address(False, 3 * 4))
"""The same, for vectors of three numbers in single precision."""
heap: Any = intrinsic(_address(True))
"""The vectors of a contiguous array."""


def _addressed(whole: bool) -> Callable[..., Any]:
    def typed(typingctx: Any, kind: Any, address: Any) -> Any:
        if not (isinstance(kind, types.NumberClass) and isinstance(address, types.Integer)):
            return None

        def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return builder.inttoptr(args[1], context.get_value_type(sig.return_type))

        return Rows(kind.instance_type, whole, VECTOR, fused=True)(kind, address), emit

    return typed


lay_at: Any = intrinsic(_addressed(False))
"""The numbers of a type, such as np.float32, that begin at an address."""
heap_at: Any = intrinsic(_addressed(True))
"""The vectors of such numbers."""


@infer_global(operator.getitem)
class _Item(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        if isinstance(args[0], Rows) and not args[0].whole and isinstance(args[1], types.Integer):
            return signature(args[0].dtype, *args)
        return None


@lower_builtin(operator.getitem, Rows, types.Integer)
def _item(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return builder.load(builder.gep(args[0], [args[1]]))


def _lanes(rows: Rows | Lanes) -> Lanes:
    """The kind of vectors that these rows hold, or that this one is."""
    return Lanes(rows.dtype, rows.size, rows.fused)


def _here(context: Any, builder: Any, kind: Rows, rows: Any, o: Any) -> Any:
    """Pointer to a vector. Functions that have vectors keep them on their stack, too; LLVM finds out too late to align
    it by itself, and half of them would lie across two cache lines, or not, as the process happens to be loaded."""
    traits = builder.function.attributes
    traits.alignstack = VECTOR
    traits.add("nounwind")  # as all of Numba's are; without any other, llvmlite does not write the alignment
    wide = context.get_value_type(_lanes(kind)).as_pointer()
    if kind.whole:
        return builder.gep(builder.bitcast(rows, wide), [o])
    return builder.bitcast(builder.gep(rows, [o]), wide)


@intrinsic
def get(typingctx: Any, rows: Any, o: Any) -> Any:
    """A vector from place o on."""
    if not (isinstance(rows, Rows) and isinstance(o, types.Integer)):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.load(_here(context, builder, sig.args[0], *args), align=sig.args[0].dtype.bitwidth // 8)

    return _lanes(rows)(rows, o), emit


@intrinsic
def put(typingctx: Any, rows: Any, o: Any, x: Any) -> Any:
    """Keep a vector from place o on; a plain number in all of its lanes."""
    if not (isinstance(rows, Rows) and isinstance(o, types.Integer)):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = sig.args[0]
        value = _wide(context, builder, args[2], sig.args[2], _lanes(kind))
        builder.store(value, _here(context, builder, kind, *args[:2]), align=kind.dtype.bitwidth // 8)
        return context.get_dummy_value()

    return types.void(rows, o, x), emit


@intrinsic
def pick(typingctx: Any, rows: Any, o: Any, x: Any, stride: Any, y: Any) -> Any:
    """A vector of the numbers at places o + stride * x + y; x: vector of whole numbers, y likewise or one number. What
    is added to o has to be less than 2^31."""
    if not (isinstance(rows, Rows) and not rows.whole and isinstance(x, Lanes) and isinstance(stride, types.Integer)):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        base, begin, first, step, second = args
        kind = _lanes(sig.args[0])
        wide = context.get_value_type(kind)
        whole = ir.VectorType(ir.IntType(32), wide.count)
        turn = context.cast(builder, step, sig.args[3], types.int32)
        none = ir.Constant(whole, ir.Undefined)
        same = ir.Constant(ir.VectorType(ir.IntType(32), wide.count), None)
        turn = builder.shuffle_vector(builder.insert_element(none, turn, ir.Constant(ir.IntType(32), 0)), none, same)
        place = builder.mul(builder.fptosi(first, whole), turn)
        place = builder.add(place, builder.fptosi(_wide(context, builder, second, sig.args[4], kind), whole))
        places = builder.gep(builder.gep(base, [begin]), [ir.Constant(ir.IntType(32), 0)])
        # llvmlite knows of no addresses that are vectors, LLVM does
        places.indices, places.operands = [place], [places.pointer, place]
        places.type = ir.VectorType(base.type, wide.count)
        mask = ir.Constant(ir.VectorType(ir.IntType(1), wide.count), [1] * wide.count)
        number = ir.IntType(32)
        typed = ir.FunctionType(wide, [places.type, number, mask.type, wide])
        name = f"llvm.masked.gather.v{wide.count}f{kind.dtype.bitwidth}.v{wide.count}p0"
        gather = get_or_insert_function(builder.module, typed, name)
        size = number(kind.dtype.bitwidth // 8)
        return builder.call(gather, [places, size, mask, ir.Constant(wide, ir.Undefined)])

    return _lanes(rows)(rows, o, x, stride, y), emit


@inner
def get3(rows, o, stride):
    """Vectors from places o, o + stride and o + 2 stride on."""
    return get(rows, o), get(rows, o + stride), get(rows, o + 2 * stride)


@inner
def put3(rows, o, stride, x, y, z):
    """Keep three vectors so."""
    put(rows, o, x)
    put(rows, o + stride, y)
    put(rows, o + 2 * stride, z)


@intrinsic
def deal(typingctx: Any, rows: Any, o: Any) -> Any:
    """Three vectors, of numbers that take turns from place o on."""
    if not (isinstance(rows, Rows) and isinstance(o, types.Integer)):
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

    return types.UniTuple(_lanes(rows), 3)(rows, o), emit


@intrinsic
def ask(typingctx: Any, rows: Any, o: Any) -> Any:
    """Have the processor fetch the cache line of place o, and go on meanwhile."""
    if not (isinstance(rows, Rows) and isinstance(o, types.Integer)):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        place = builder.bitcast(builder.gep(args[0], [args[1]]), ir.IntType(8).as_pointer())
        number = ir.IntType(32)
        kind = ir.FunctionType(ir.VoidType(), [place.type, number, number, number])
        fetch = get_or_insert_function(builder.module, kind, "llvm.prefetch.p0")
        builder.call(fetch, [place, number(FOR_READING), number(SECOND_CACHE), number(DATA)])
        return context.get_dummy_value()

    return types.void(rows, o), emit


@inner
def ask3(rows, o, stride):
    """Have three places fetched, o, o + stride and o + 2 stride."""
    ask(rows, o)
    ask(rows, o + stride)
    ask(rows, o + 2 * stride)


@intrinsic
def width(typingctx: Any, rows: Any) -> Any:
    """How many lanes a vector of these rows has."""
    if not isinstance(rows, Rows):
        return None
    count = _lanes(rows).mask.count
    return types.int64(rows), lambda context, builder, sig, args: context.get_constant(types.int64, count)


@intrinsic
def where(typingctx: Any, mask: Any, x: Any, y: Any) -> Any:
    """x in lanes where the mask holds, else y."""
    wide = [one for one in (x, y) if isinstance(one, Lanes)]
    if not isinstance(mask, Mask) or not wide:
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = sig.return_type
        first, second = (_wide(context, builder, v, t, kind) for v, t in zip(args[1:], sig.args[1:], strict=True))
        return builder.select(args[0], first, second)

    return wide[0](mask, x, y), emit


@intrinsic
def some(typingctx: Any, mask: Any) -> Any:
    """Whether a mask holds in any lane."""
    if not isinstance(mask, Mask):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = ir.IntType(sig.args[0].count)
        return builder.icmp_unsigned("!=", builder.bitcast(args[0], kind), ir.Constant(kind, 0))

    return types.boolean(mask), emit


@intrinsic
def pattern(typingctx: Any, mask: Any) -> Any:
    """The lanes in which a mask holds, as bits of a number, the first the lowest."""
    if not isinstance(mask, Mask):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        bits = builder.bitcast(args[0], ir.IntType(sig.args[0].count))
        return builder.zext(bits, context.get_value_type(sig.return_type))

    return types.uint64(mask), emit


@intrinsic
def tally(typingctx: Any, mask: Any) -> Any:
    """In how many lanes a mask holds."""
    if not isinstance(mask, Mask):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        bits = builder.bitcast(args[0], ir.IntType(sig.args[0].count))
        return builder.zext(builder.ctpop(bits), context.get_value_type(sig.return_type))

    return types.uint64(mask), emit


def _of_each(function: str, doc: str) -> Any:
    """An LLVM function of each lane."""
    call = _call(function)

    def typed(typingctx: Any, x: Any) -> Any:
        if not isinstance(x, Lanes):
            return None
        return x(x), lambda context, builder, sig, args: call(builder, *args)

    typed.__doc__ = doc
    return intrinsic(typed)


root = _of_each("llvm.sqrt", "Square root.")
whole = _of_each("llvm.floor", "The greatest whole number that is no greater.")
sine = _of_each("llvm.sin", "Sine of radians, number by number: not to be used where time counts.")
cosine = _of_each("llvm.cos", "Cosine likewise.")


@intrinsic
def rounded(typingctx: Any, x: Any) -> Any:
    """A product as a number of its own, which is not fused."""
    if not isinstance(x, Lanes):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = args[0].type
        return builder.fadd(args[0], ir.Constant(kind, [-0.0] * kind.count))  # which changes no number

    return x(x), emit


@intrinsic
def greatest(typingctx: Any, x: Any) -> Any:
    """The greatest number of all lanes, none of which is NaN."""
    if not isinstance(x, Lanes):
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
def spread(typingctx: Any, like: Any, x: Any) -> Any:
    """The number x in all lanes of a vector, of the kind of numbers that rows or a vector ``like`` hold."""
    if not (isinstance(like, (Rows, Lanes)) and isinstance(x, types.Number)):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _wide(context, builder, args[1], sig.args[1], sig.return_type)

    return _lanes(like)(like, x), emit


@inner
def deal_out(rows, o, count, work, to, stride):
    """So many triples of numbers from place o on into a flat array, from places to, to + stride and to + 2 stride on:
    vectors as far as they go."""
    out = strip(work)
    whole = count - count % width(rows)
    for k in range(0, whole, width(rows)):
        x, y, z = deal(rows, o + 3 * k)
        put3(out, to + k, stride, x, y, z)
    for k in range(whole, count):
        work[to + k] = rows[o + 3 * k]
        work[to + k + stride] = rows[o + 3 * k + 1]
        work[to + k + 2 * stride] = rows[o + 3 * k + 2]
