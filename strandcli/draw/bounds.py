"""The box about strands."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..constants import W


def bounds_of(
    positions: NDArray[np.float32], strands: int, fade: NDArray[np.float32] | None = None
) -> NDArray[np.float64]:
    """Box (2, 3) of the first ``strands`` of positions (blocks, n + 1, 3 W), metres: of no others, so that a frame is
    the same whichever strands other frames need. ``fade`` (strands,): those that are there in part widen the box by as
    much less, so that it does not jump."""
    rows = positions.reshape(*positions.shape[:2], 3, W)[:, 1:]
    if fade is None:
        whole = strands // W
        parts = [rows[:whole], rows[whole : whole + 1, ..., : strands - whole * W]]
        parts = [part for part in parts if part.size]
        low = np.min([part.min((0, 1, 3)) for part in parts], 0)
        return np.stack([low, np.max([part.max((0, 1, 3)) for part in parts], 0)]).astype(np.float64)
    low, high = (
        side.transpose(0, 2, 1).reshape(-1, 3)[:strands].astype(np.float64) for side in (rows.min(1), rows.max(1))
    )
    full = fade == fade.max()
    inner = np.stack([low[full].min(0), high[full].max(0)])
    part = fade[:, None]
    lower, higher = ((low - inner[0]) * part).min(0), ((high - inner[1]) * part).max(0)
    return np.asarray(inner + np.stack([np.minimum(lower, 0), np.maximum(higher, 0)]))
