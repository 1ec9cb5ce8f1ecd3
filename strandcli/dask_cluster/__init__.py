"""Frames drawn by the workers of a Dask cluster: the scene is simulated once, by the process that asks, and each frame's
positions go to whichever worker is free. Nothing but `strandcli render --dask` imports this package."""
