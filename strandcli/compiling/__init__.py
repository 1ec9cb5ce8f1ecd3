"""When and where kernels are compiled: the cache's folder, worker processes, claims, the time spent.

Nothing here imports Numba but the worker, so that what never draws starts at once.
"""
