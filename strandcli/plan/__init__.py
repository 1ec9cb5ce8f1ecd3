"""The plan of a scene: stages that run, stages that are left out and why, and memory. Imports neither NumPy nor Numba.

The decisions are those of the drivers, which use the same conditions.
"""

from ..common.limits import SHARE, available_memory
from ..draw.shadows.shadow_model import needs_counts, needs_shadow_maps
from .decisions import Stage
from .make import Plan, checked_plan, make_plan, pictures_that_fit, require_memory
