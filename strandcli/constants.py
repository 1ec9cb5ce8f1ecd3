"""Numbers that several rooms share, without importing anything."""

W = 128
"""Strands a block, one a lane: LLVM's interleaved vector loops need 64 to run at all; 128 measured a sixth faster."""

PORTION = 6_000_000
"""Vertices that are drawn at once, 36 bytes each: more go through in portions."""
