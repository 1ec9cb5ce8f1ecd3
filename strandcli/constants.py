"""Numbers that several rooms share, without importing anything."""

W = 128
"""Strands a block, one a lane: LLVM's interleaved vector loops need 64 to run at all; 128 measured a sixth faster."""

PORTION = 6_000_000
"""Vertices that are drawn at once, 36 bytes each: more go through in portions."""

GRID_BYTES = 1_000_000_000
"""For the lists of a light with exact shadows, about; where they would take more, they are coarser."""
FRAGMENTS = 4_194_304
"""Fragments of sorted strands that are held at once, `FRAGMENT_BYTES` each: more go through in bands of rows."""

FRAGMENT_BYTES = 28
"""A fragment: depth, index, opacity, place and pixel as it is found; vertex, weight and place once it is sorted."""

VECTOR = 64
"""Bytes of numbers that move at once, those of a cache line: of sixteen strands, or of eight in double precision."""
