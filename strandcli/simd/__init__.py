"""Numbers of several strands at once as a type of Numba's own: one LLVM vector, which lives in registers.

Kernels that work a row of lanes at a time through memory depend on what LLVM's loop vectoriser happens to see, and on a
cache that holds all rows. With this type a kernel is written for one strand, moves `VECTOR` bytes' worth of them, and
vectorises always; a vector that is wider than the machine's registers takes several.

    rows = pointer(array)            the numbers of a contiguous array of any shape, one after the other
    rows = half_width_pointer(array) the same, and vectors of half as many: where most loops are short
    rows = triple_pointer(array)     the same, and vectors of three numbers in single precision
    rows = quadruple_pointer(array)  the same of four, or of four whole numbers of 32 bits
    pile = vector_pointer(array)     the vectors of a contiguous array: place 1 is that of the second vector
    rows = fused_pointer(array); pile = fused_vector_pointer(array)
                                     the same, and products in sums are fused (FMA)
    fused_pointers(arrays)           a named tuple of arrays as one of the fused pointer of each
    shifted(pile, 3)                 the vectors from place 3 on
    rows[o]                          a number
    rows = line_pointer(array)       those of a contiguous array from the first on that begins a cache line
    array_at(np.int32, a, (n, 3))    an array of numbers that begin at an address
    lane_count(rows)                 numbers in a vector
    x = load(rows, o)                a vector from place o on
    gather(rows, o, x, stride, y)    a vector of the numbers at places o + stride * x + y; x and y are whole
    gather2(rows, o, x, stride, y), gather4(…), gather8(…)   two, four or eight vectors: of those numbers and of the
                                     ones after them
    store(rows, o, x)
    store_records(rows, o, eight)    eight vectors as records: the first number of each, the second of each, ...
    x, y, z = load3(rows, o, stride); store3(rows, o, stride, x, y, z)
    x, y, z = load_deinterleaved(rows, o)   vectors of every third number from places o, o + 1 and o + 2 on
    a, b, c = load_triple(rows, o)   three vectors one behind the other, in which three numbers take turns
    a, b, c, d = load_quadruples(rows, o)   vectors of every fourth number, likewise
    a, b = deinterleaved(x)          vectors of half the length, of the even lanes and of the odd ones
    x, y = interleaved(a, b)         two vectors, one behind the other, in which the numbers of two take turns
    deinterleave(rows, o, count, work, to, stride)   the same of so many triples, into an array
    x + y, x - 1.0, -x, x * y, x / y, abs(x), max(x, y), min(x, y), sqrt(x), floor(x),
    power_of_two(x)
    where(x < y, a, b)               lane by lane, also for !=; masks are joined with &, | and ~
    any_lane(x < y)                  whether it holds in any lane
    movemask(x < y)                  in which, as bits of a number, the first the lowest
    count_true(x < y)                in how many
    reduce_max(x), broadcast(x, 2.0)
    bits_of_places(o, x, stride, y)  the whole numbers o + stride * x + y, to be stored
    lane(x, k), with_lane(x, k, 2.0) the number in one lane, and the vector with another one there: slow
    no_fma(x * y) + z                rounds the product, where it would be fused
    prefetch3(rows, o, stride)       has the processor fetch what `load3` is going to read; any address is allowed

Vectors of whole numbers can be loaded and stored, and no more. Numbers that are not vectors stand for lanes that are
all equal. max and min return their first argument where one is NaN that comes second, as Numba's do. Rows are no more
than an address: handing them on costs nothing, where an array's references are counted, and who calls keeps the
array. Places are not checked, and arithmetic is IEEE 754's, so that bits are those of scalars.

Vectors of fused pointers are fused: a product that is added or subtracted where it is written is not rounded
before, as IEEE 754's fusedMultiplyAdd, of two products the second. That is one operation where it was two, and which
products it is, is settled here and not by LLVM: bits are the same on all processors that have it.
"""

from __future__ import annotations

from .arithmetic import has_fma
from .lanes import (
    any_lane,
    bits_of_places,
    broadcast,
    count_true,
    floor,
    lane,
    movemask,
    no_fma,
    power_of_two,
    reduce_max,
    sqrt,
    where,
    with_lane,
)
from .memory import (
    array_at,
    deinterleave,
    fused_pointer,
    fused_pointers,
    fused_vector_pointer,
    gather,
    half_width_pointer,
    lane_count,
    line_pointer,
    load,
    load3,
    load_deinterleaved,
    pointer,
    prefetch,
    prefetch3,
    quadruple_pointer,
    shifted,
    store,
    store3,
    triple_pointer,
    vector_pointer,
)
from .records import (
    deinterleaved,
    gather2,
    gather4,
    gather8,
    interleaved,
    load_quadruples,
    load_triple,
    store_records,
)
