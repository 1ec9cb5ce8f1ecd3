"""Solids of the four shapes that have kernels of their own, in kernels that may be given none of them.

The type `Lone…` of solids tells that all of them are custom ones. What the four shapes take is not compiled for it.
"""

from __future__ import annotations

from typing import Any

from ...jit.pruned import device_where


def may_be_there(solids: Any) -> bool:
    """Whether solids of this type may be spheres, capsules, planes or boxes."""
    return bool(getattr(solids.instance_class, "built_in", True))


def device_if_built_in(otherwise: Any) -> Any:
    """A decorator: `device`, for kernels whose solids may be of the four shapes; else ``otherwise``."""
    return device_where(may_be_there, otherwise)


@device_if_built_in(lambda solids: 0)
def count(solids):
    """Return the number of spheres, capsules, planes and boxes."""
    return solids.spheres.shape[0] + solids.capsules.shape[0] + solids.planes.shape[0] + solids.boxes.shape[0]
