"""Numbers that lie beside each other at a place of each lane's own: fetched together, and then sorted into vectors.

A processor fetches the lanes of a `gather` one by one, so four gathers cost as much as sixty-four loads. Where what a
lane needs lies in one piece, a load brings all of it, and a few shuffles turn rows into columns.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.extending import intrinsic

from ..jit import device
from .kinds import PointerType, VectorType, places_of, vector_of
from .memory import lane_count, store

INDEX = ir.IntType(32)
LANE = 4
"""Numbers in single precision within which a processor moves any to any place at the least cost."""


def _of_records(size: int) -> Callable[..., Any]:
    def typed(typingctx: Any, rows: Any, o: Any, x: Any, stride: Any, y: Any) -> Any:
        if not (
            isinstance(rows, PointerType)
            and not rows.whole
            and isinstance(x, VectorType)
            and isinstance(stride, types.Integer)
        ):
            return None

        def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            kind, place = vector_of(sig.args[0]), places_of(context, builder, sig, args)
            count = place.type.count
            start = builder.gep(args[0], [args[1]])
            record = ir.VectorType(start.type.pointee, size)
            found = []
            for k in range(count):
                at = builder.sext(builder.extract_element(place, INDEX(k)), ir.IntType(64))
                here = builder.bitcast(builder.gep(start, [at]), record.as_pointer())
                found.append(builder.load(here, align=kind.dtype.bitwidth // 8))
            return context.make_tuple(builder, sig.return_type, columns(builder, found, size))

        return types.UniTuple(vector_of(rows), size)(rows, o, x, stride, y), emit

    return typed


def columns(builder: Any, records: list[Any], size: int) -> list[Any]:
    """Vectors of the first number of each record, of the second, and so on; records: vectors of so many numbers, which
    divides how many there are."""
    if size % LANE == 0 and len(records) % (2 * LANE) == 0 and size <= 2 * LANE:
        return by_lanes(builder, records, size // LANE)
    full = list(records)
    while len(full) > size:  # until each is as long as a vector of one number a record
        full = in_pairs(builder, full)
    return turns(builder, full, size)


def by_lanes(builder: Any, records: list[Any], chunks: int) -> list[Any]:
    """As `columns`, of records of one or two times `LANE` numbers. Records that stand beside each other in a vector are
    `LANE` apart, so that rows become columns within each `LANE` numbers, which costs least."""
    half = len(records) // chunks
    found = []
    for begin in range(0, len(records), half):
        rows = []
        for row in range(LANE):
            wide = records[begin + row : begin + half : LANE]
            while len(wide) > 1:
                wide = in_pairs(builder, wide)
            rows.append(wide[0])
        low = [_in_lanes(builder, rows[k], rows[k + 1], (0, LANE, 1, LANE + 1)) for k in (0, 2)]
        high = [_in_lanes(builder, rows[k], rows[k + 1], (2, LANE + 2, 3, LANE + 3)) for k in (0, 2)]
        found.append(
            [
                _in_lanes(builder, pair[0], pair[1], places)
                for pair in (low, high)
                for places in ((0, 1, LANE, LANE + 1), (2, 3, LANE + 2, LANE + 3))
            ]
        )
    if chunks == 1:
        return found[0]
    count = len(records)
    picked = [[at for at in range(2 * count) if at // LANE % 2 == odd] for odd in range(2)]
    return [builder.shuffle_vector(a, b, _mask(places)) for places in picked for a, b in zip(*found, strict=True)]


def _in_lanes(builder: Any, a: Any, b: Any, places: tuple[int, ...]) -> Any:
    """A vector that has, in each `LANE` places, those of two vectors: the first ones of the first, then of the
    second."""
    count = a.type.count
    own = [(place % LANE) + (count if place >= LANE else 0) for place in places]
    return builder.shuffle_vector(a, b, _mask([at + k for at in range(0, count, LANE) for k in own]))


def in_pairs(builder: Any, vectors: list[Any]) -> list[Any]:
    """Vectors, each behind the one before it."""
    count = vectors[0].type.count
    return [
        builder.shuffle_vector(a, b, _mask(list(range(2 * count))))
        for a, b in zip(vectors[::2], vectors[1::2], strict=True)
    ]


def _mask(places: list[int]) -> Any:
    return ir.Constant(ir.VectorType(INDEX, len(places)), places)


gather2: Any = intrinsic(_of_records(2))
"""Two vectors: of the numbers that `gather` gives, and of those after them."""
gather4: Any = intrinsic(_of_records(4))
"""Four vectors: of the numbers that `gather` gives, and of those one, two and three places after them."""
gather8: Any = intrinsic(_of_records(8))
"""Eight vectors, likewise."""


@intrinsic
def load_triple(typingctx: Any, rows: Any, o: Any) -> Any:
    """Three vectors, one after the other, in which three numbers from place o on take turns."""
    if not (isinstance(rows, PointerType) and isinstance(o, types.Integer)):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = sig.args[0]
        count = context.get_value_type(vector_of(kind)).count
        place = builder.gep(args[0], [args[1]])
        triple = builder.load(
            builder.bitcast(place, ir.VectorType(place.type.pointee, 3).as_pointer()), align=kind.dtype.bitwidth // 8
        )
        turns = ir.VectorType(ir.IntType(32), count)
        out = [
            builder.shuffle_vector(triple, triple, ir.Constant(turns, [(k + i) % 3 for k in range(count)]))
            for i in (0, count, 2 * count)
        ]
        return context.make_tuple(builder, sig.return_type, out)

    return types.UniTuple(vector_of(rows), 3)(rows, o), emit


@intrinsic
def load_quadruples(typingctx: Any, rows: Any, o: Any) -> Any:
    """Four vectors, of numbers that take turns from place o on."""
    if not (isinstance(rows, PointerType) and not rows.whole and isinstance(o, types.Integer)):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = vector_of(sig.args[0])
        wide = context.get_value_type(kind)
        start = builder.bitcast(builder.gep(args[0], [args[1]]), wide.as_pointer())
        align = kind.dtype.bitwidth // 8
        found = [builder.load(builder.gep(start, [INDEX(k)]), align=align) for k in range(LANE)]
        return context.make_tuple(builder, sig.return_type, turns(builder, found, LANE))

    return types.UniTuple(vector_of(rows), LANE)(rows, o), emit


def turns(builder: Any, full: list[Any], size: int) -> list[Any]:
    """Vectors of every number out of ``size`` that take turns in as many vectors, from the first of these on."""
    each = full[0].type.count // size
    out = []
    for c in range(size):
        parts = [
            builder.shuffle_vector(a, b, _mask([size * k + c for k in range(2 * each)]))
            for a, b in zip(full[::2], full[1::2], strict=True)
        ]
        while len(parts) > 1:
            parts = in_pairs(builder, parts)
        out.append(parts[0])
    return out


@intrinsic
def interleaved(typingctx: Any, x: Any, y: Any) -> Any:
    """Two vectors, one behind the other, in which numbers of two take turns."""
    if not (isinstance(x, VectorType) and x == y):
        return None

    def emit(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        count = args[0].type.count
        turns = [place for k in range(count) for place in (k, count + k)]
        halves = [builder.shuffle_vector(*args, _mask(half)) for half in (turns[:count], turns[count:])]
        return context.make_tuple(builder, sig.return_type, halves)

    return types.UniTuple(x, 2)(x, y), emit


@device
def store_records(rows, o, numbers):
    """Keep eight vectors as records from place o on: the first number of each, then the second, and so on."""
    a, b, c, d, e, f, g, h = numbers
    first, third, second, fourth = interleaved(a, e), interleaved(c, g), interleaved(b, f), interleaved(d, h)
    for half in range(2):
        odd, even = interleaved(first[half], third[half]), interleaved(second[half], fourth[half])
        for quarter in range(2):
            low, high = interleaved(odd[quarter], even[quarter])
            store(rows, o, low)
            store(rows, o + lane_count(rows), high)
            o += 2 * lane_count(rows)
