"""A run: the pipeline of stages from a scene to its frames, and the states that it goes on from."""
