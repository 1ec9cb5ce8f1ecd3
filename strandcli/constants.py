"""Numbers that several rooms share, without importing anything."""

W = 128
"""Strands a block, one a lane: LLVM's interleaved vector loops need 64 to run at all; 128 measured a sixth faster."""

BATCH_VERTICES = 6_000_000
"""Vertices that a z-buffer draws at once, 36 bytes each: more strands go through in batches."""

SORTED_POINTS, FILE_POINTS = 8_000_000, 2_000_000
"""Points of strands that are sorted at once, and of a file's, whose pictures are to take little more memory than they
do; more are, in batches, drawn in bands of rows, which takes longer."""

BAND_VERTICES, BANDS = 650_000, 16
"""Vertices of a batch and of a band of rows, about, and most bands: a strand is made once for each that it comes to."""

FRAGMENTS = 4_194_304
"""Fragments of sorted strands that are in memory at once, `FRAGMENT_BYTES` each: more go through in bands of rows."""

SORTED_BYTES = 12
"""A fragment once it is sorted: vertex, weight and place."""

PART_BYTES = 20
"""A part of a strand in a tile: strand, first and last vertex, where its run began, and its depth."""

FRAGMENT_BYTES = 2 * SORTED_BYTES + PART_BYTES
"""At most: threads do not find the same number, and a part may leave no more than one fragment."""

LAYER_ROOM = 1.5
"""Times the fragments that are foreseen in the rows of a layer, for which there is room: strands move, threads do not
find the same number, the last block of a chain is not full, and what sorts a crowded tile takes less in a thin
layer."""

SORTING_BYTES = 36
"""A fragment of a tile while these are sorted: twice its numbers, and its depth."""

VECTOR = 64
"""Bytes of numbers that move at once, those of a cache line: of sixteen strands, or of eight in double precision."""
FOLD = 0.02
"""Of rods, least of 1 + e_{j−1}·e_j, which is 0 where a strand is folded onto itself and frames have no direction."""
