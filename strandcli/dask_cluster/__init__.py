"""Frames drawn by the workers of a Dask cluster. The scene is simulated once, by the process that asks, and each
frame's positions go to whichever worker is free."""
