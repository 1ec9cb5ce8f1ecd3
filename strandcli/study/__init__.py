"""Measuring instruments: how right, how fast and how stable everything else is. What runs presets needs none."""
