"""Exact solutions that solvers are held to: rods at rest, small oscillations, springs, friction, density."""

from __future__ import annotations

from collections.abc import Mapping

from . import elastica, incline, layer, oscillation, spring, tuft
from .base import Case, Reference, Track

REFERENCES: Mapping[str, Reference] = {
    one.name: one
    for one in (
        elastica.ELASTICA, oscillation.BEAM, oscillation.SWING, spring.SPRING, incline.INCLINE, layer.LAYER,
        tuft.TUFT,
    )
}  # fmt: skip
"""By name, in the order in which `--reference all` goes through them."""
