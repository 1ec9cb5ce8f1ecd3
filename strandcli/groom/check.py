"""Refuses strands that nothing can be made of, by name, before a solver is given them."""

from __future__ import annotations

import numpy as np

from ..errors import UsageError
from .record import Groom

UNIT = 1e-3
"""How far a direction may be from a unit vector."""


def check(groom: Groom) -> None:
    """Raise `UsageError` for the first strand whose root, direction or length cannot be simulated; says how many."""
    with np.errstate(invalid="ignore", over="ignore"):
        sizes = np.linalg.norm(groom.directions.astype(np.float64), axis=1)
        found = (
            (~np.isfinite(groom.roots).all(1), "its root is not finite"),
            (~(np.abs(sizes - 1) <= UNIT), "its direction is no unit vector"),
            (~np.isfinite(groom.lengths), "its length is not finite"),
            (~(groom.lengths > 0), "it has no length: its particles coincide"),
        )
    for bad, words in found:
        if bad.any():
            strand, count = int(np.argmax(bad)), int(bad.sum())
            others = f" ({count} such strands)" if count > 1 else ""
            raise UsageError(f"groom: strand {strand}: {words}{others}; leave it out, or mend it where it was made")
