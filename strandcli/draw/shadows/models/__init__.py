"""Shadow models, one driver each: what strands leave of a light. `common.registry.SHADOWS` finds them by name.

A shadow model is an object of a class derived from `strandcli.draw.shadows.shadow_model.ShadowModel`, which says what
each of its parts means. Drivers import numpy and numba only inside of functions: `strandcli plan` does without.
"""
