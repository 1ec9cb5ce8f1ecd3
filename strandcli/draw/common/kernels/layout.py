"""Users of a batch's rows and their stages, in order. `soft_rows`, `batch` and `surface_batch` allocate the rows."""

from __future__ import annotations

from ....constants import W
from ..rows import RowAllocator

layout = RowAllocator(
    W,
    {
        # "light" to "darken" run once for each light; "soft": shadows of solids in lights with a size
        "strands": ("gather", "ambient", "light", "soft", "maps", "dual", "highlights", "darken", "out"),
        "surfaces": ("gather", "ambient", "light", "soft", "maps", "reflect", "out"),
    },
)
