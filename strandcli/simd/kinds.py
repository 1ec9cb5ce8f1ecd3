"""What Numba knows of vectors: their types, how LLVM has them, and what becomes of a number among them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.cgutils import get_or_insert_function
from numba.core.datamodel import models
from numba.core.extending import register_model


class VectorType(types.Type):
    """A vector of numbers, ``size`` bytes of them; ``fused``: products that are terms of a sum are not rounded."""

    def __init__(self, dtype: Any, size: int, fused: bool) -> None:
        self.dtype, self.size, self.fused = dtype, size, fused
        self.mask = Mask(size * 8 // dtype.bitwidth)
        super().__init__(f"{'Fused' * fused}VectorType({dtype}, {size})")


class Mask(types.Type):
    """A vector of truth values."""

    def __init__(self, count: int) -> None:
        self.count = count
        super().__init__(f"Mask({count})")


class PointerType(types.Type):
    """Numbers in memory, or vectors of them where ``floor``; vectors have ``size`` bytes, and are ``fused`` or not."""

    def __init__(self, dtype: Any, whole: bool, size: int, fused: bool) -> None:
        self.dtype, self.whole, self.size, self.fused = dtype, whole, size, fused
        super().__init__(f"{'Fused' * fused}{'Heap' if whole else 'PointerType'}({dtype}, {size})")


@register_model(VectorType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: VectorType) -> None:
        super().__init__(manager, kind, ir.VectorType(manager.lookup(kind.dtype).get_value_type(), kind.mask.count))


@register_model(Mask)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Mask) -> None:
        super().__init__(manager, kind, ir.VectorType(ir.IntType(1), kind.count))


@register_model(PointerType)
class _RowsModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: PointerType) -> None:
        super().__init__(manager, kind, manager.lookup(kind.dtype).get_value_type().as_pointer())


def vector_of(rows: PointerType | VectorType) -> VectorType:
    """The kind of vectors that these rows hold, or that this one is."""
    return VectorType(rows.dtype, rows.size, rows.fused)


def widened(context: Any, builder: Any, value: Any, given: Any, kind: VectorType) -> Any:
    """A lowered argument as a vector of this kind; a number goes to all lanes."""
    if isinstance(given, VectorType):
        return value
    value = context.cast(builder, value, given, kind.dtype)
    wide = context.get_value_type(kind)
    none = ir.Constant(wide, ir.Undefined)
    first = builder.insert_element(none, value, ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(first, none, ir.Constant(ir.VectorType(ir.IntType(32), wide.count), None))


def places_of(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Of lowered arguments (rows, o, x, stride, y) the whole numbers stride * x + y, a vector of 32 bits each."""
    kind = next(one for one in sig.args if isinstance(one, VectorType))
    whole = ir.VectorType(ir.IntType(32), kind.mask.count)
    none = ir.Constant(whole, ir.Undefined)
    stride = context.cast(builder, args[3], sig.args[3], types.int32)
    stride = builder.insert_element(none, stride, ir.Constant(ir.IntType(32), 0))
    product = builder.mul(
        builder.fptosi(args[2], whole), builder.shuffle_vector(stride, none, ir.Constant(whole, None))
    )
    return builder.add(product, builder.fptosi(widened(context, builder, args[4], sig.args[4], kind), whole))


def call_of(name: str, count: int = 1) -> Callable[..., Any]:
    """What LLVM has by a name, of so many vectors."""

    def emit(builder: Any, *args: Any) -> Any:
        wide = args[0].type
        width = "f32" if wide.element == ir.FloatType() else "f64"
        kind = ir.FunctionType(wide, [wide] * count)
        return builder.call(get_or_insert_function(builder.module, kind, f"{name}.v{wide.count}{width}"), args)

    return emit
