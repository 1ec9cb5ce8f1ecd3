"""What a scene needs, what is left out and why, and the memory that it takes. Imports neither numpy nor numba.

The decisions are the drivers' own: they leave a stage out by the same conditions that are told here.
"""

from ..draw.shadows.needs import needs_counts, needs_shadow_maps
from .free import available_memory, require_memory
from .make import Plan, Stage, make_plan, needed_strands, pictures_that_fit

__all__ = [
    "Plan",
    "Stage",
    "available_memory",
    "make_plan",
    "needed_strands",
    "needs_counts",
    "needs_shadow_maps",
    "pictures_that_fit",
    "require_memory",
]
