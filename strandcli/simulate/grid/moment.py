"""The step that the grid of strands that interact is laid for."""

from __future__ import annotations

from typing import NamedTuple

from ...solids import Solids


class Moment(NamedTuple):
    """The step that strands are prepared for."""

    time: float
    """At its end, seconds."""
    step: float
    """Its length, seconds."""
    wind: tuple[float, float, float]
    """Acceleration of strands at rest by the open wind, m/s²."""
    gravity: tuple[float, float, float]
    """m/s²."""
    solids: Solids | None
    """Those that strands collide with, at its end."""
