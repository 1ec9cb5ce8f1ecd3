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

from .arithmetic import fuses
from .lanes import cosine, greatest, pattern, root, rounded, sine, some, spread, tally, where, whole
from .memory import (
    ask,
    ask3,
    deal,
    deal_out,
    get,
    get3,
    heap,
    heap_at,
    lay,
    lay_at,
    pick,
    put,
    put3,
    strip,
    three,
    width,
)

__all__ = [
    "ask", "ask3", "cosine", "deal", "deal_out", "fuses", "get", "get3", "greatest", "heap", "heap_at", "lay",
    "lay_at", "pattern", "pick", "put", "put3", "root", "rounded", "sine", "some", "spread", "strip", "tally", "three",
    "where", "whole", "width",
]  # fmt: skip
