"""Compiled loops of the foil."""
