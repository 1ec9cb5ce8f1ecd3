"""Compiled loops over strands of a file."""
