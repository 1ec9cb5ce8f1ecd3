"""Validation of a groom before it is simulated."""

from __future__ import annotations

import numpy as np

from ..errors import UsageError
from .record import Groom

UNIT = 1e-3
"""Tolerance of a direction's length."""


def check(groom: Groom) -> None:
    """Raise `UsageError` for the first strand whose root, direction or length is invalid, with the number of such
    strands."""
    with np.errstate(invalid="ignore", over="ignore"):
        sizes = np.linalg.norm(groom.directions.astype(np.float64), axis=1)
        found = (
            (~np.isfinite(groom.roots).all(1), "its root is not finite"),
            (~(np.abs(sizes - 1) <= UNIT), "its direction is no unit vector"),
            (~np.isfinite(groom.lengths), "its length is not finite"),
            (~(groom.lengths > 0), "its length is not positive"),
        )
    for bad, words in found:
        if bad.any():
            strand, count = int(np.argmax(bad)), int(bad.sum())
            others = f" ({count} such strands)" if count > 1 else ""
            raise UsageError(f"groom: strand {strand}: {words}{others}; leave it out, or mend it where it was made")
