"""Compiled loops of studies of pictures."""
