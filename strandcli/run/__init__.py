"""A run: the pipeline of stages from a scene to its frames, and what is remembered on the way."""
