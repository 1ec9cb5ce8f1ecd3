"""Who works on a batch, and in which stages: rows are handed out in `soft_rows`, `batch` and `surface_batch`."""

from __future__ import annotations

from ....constants import W
from ..rows import RowAllocator

layout = RowAllocator(
    W,
    {
        # from "light" to "darken" once a light; "soft": shadows of solids in lights with a size
        "strands": ("gather", "ambient", "light", "soft", "maps", "dual", "highlights", "darken", "out"),
        "surfaces": ("gather", "ambient", "light", "soft", "maps", "reflect", "out"),
    },
)
