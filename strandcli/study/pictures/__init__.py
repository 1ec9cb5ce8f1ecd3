"""Axes of pictures: what each approximation of drawing costs and how far off it is, measured against a reference."""
