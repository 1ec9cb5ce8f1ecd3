"""The scale of the table of light that strands keep from what is behind them."""

from __future__ import annotations

import numpy as np

HALF_WAY = np.float32(2.0)
"""Strands τ in the middle of the table."""
