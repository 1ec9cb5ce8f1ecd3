"""Boundary-value problems and eigenproblems of strands, solved in double precision: no solver, no scene."""
