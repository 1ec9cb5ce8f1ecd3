"""The scale of the tables of what strands before a solid leave of the light on it."""

from __future__ import annotations

import numpy as np

HALF_WAY = np.float32(2.0)
"""τ in the middle of a veil's table."""
