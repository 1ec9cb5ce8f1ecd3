"""Scale of the table of light that strands take from what lies behind them, over optical depth."""

from __future__ import annotations

import numpy as np

HALF_WAY = np.float32(2.0)
"""Optical depth τ at the middle of the table."""
