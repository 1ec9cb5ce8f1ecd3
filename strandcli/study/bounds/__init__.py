"""Bounds on the time of a frame's stages: loops that do only what a stage cannot do without."""
