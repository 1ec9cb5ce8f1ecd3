"""Exact solutions that any solver is measured with, one file each."""

from __future__ import annotations

from collections.abc import Mapping

from . import (
    beam,
    buckling,
    catenary,
    chain,
    elastica,
    free_swing,
    incline,
    layer,
    pendulum,
    spring,
    tip_load,
    tuft,
)
from .base import NEEDS, Case, Reference, Track

REFERENCES: Mapping[str, Reference] = {
    module.REFERENCE.name: module.REFERENCE
    for module in (
        elastica,
        tip_load,
        buckling,
        beam,
        chain,
        free_swing,
        catenary,
        pendulum,
        spring,
        incline,
        layer,
        tuft,
    )
}
"""By name, in the order in which `--reference all` goes through them."""

__all__ = ["NEEDS", "REFERENCES", "Case", "Reference", "Track"]
