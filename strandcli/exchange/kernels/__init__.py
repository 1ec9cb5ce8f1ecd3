"""Compiled loops over strands."""
