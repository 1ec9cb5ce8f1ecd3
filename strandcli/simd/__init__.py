"""Numbers of several strands at once as a type of Numba's own: one LLVM vector, which lives in registers.

Kernels that work a row of lanes at a time through memory depend on what LLVM's loop vectoriser happens to see, and on a
cache that holds all rows. With this type a kernel is written for one strand, moves `VECTOR` bytes' worth of them, and
vectorises always; a vector that is wider than the machine's registers takes several.

    rows = pointer(array)              the numbers of a contiguous array of any shape, one after the other
    pile = vector_pointer(array)       its vectors: place 1 is that of the second vector
    rows[o], load(rows, o)             a number, and a vector from place o on
    x, y, z = load3(rows, o, stride)   three vectors; store and store3 likewise
    gather(rows, o, x, stride, y)      a vector of the numbers at places o + stride * x + y
    x + y, x - 1.0, -x, x * y, x / y, abs(x), max(x, y), min(x, y), sqrt(x), floor(x)
    where(x < y, a, b)                 lane by lane, also for !=; masks are joined with &, | and ~
    any_lane(x < y)                    whether it holds in any lane

`memory` and `records` have what else vectors come from and go to, `lanes` what else is done with them, `vectors` the
algebra of three of them.

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
    gather2,
    gather4,
    gather8,
    interleaved,
    load_quadruples,
    load_triple,
    store_records,
)
