"""Memory of sorted fragments that plans reckon with. Imports neither numpy nor numba."""

from __future__ import annotations

LAYER_ROOM = 1.5
"""Times the fragments that are foreseen in the rows of a layer, for which there is room: strands move, threads do not
find the same number, the last block of a chain is not full, and what sorts a crowded tile takes less in a thin
layer."""
SORTING_BYTES = 36
"""A fragment of a tile while these are sorted: twice its numbers, and its depth."""
