"""Grooms of other programs: files of strands, what is in them, and what is changed between two."""
