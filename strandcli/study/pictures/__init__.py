"""Axes of pictures: what each approximation of drawing costs and how far off it is, measured against a reference.

One file an axis: its parameters, its reference, its metric. What they share, a preset's frame drawn in linear light
with the time of every stage, is in `subject`.
"""
