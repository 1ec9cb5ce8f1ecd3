"""Interaction: strands push each other apart where they are too dense, and take on the velocity of those around them.

A grid about the strands holds their density and momentum (Petrovic et al. 2005; McAdams et al. 2009; thesis §5). It
needs velocities and forces, so the solver `rod` alone applies it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...scene.fields import number
from .rule import Pass

if TYPE_CHECKING:
    from ...scene.model import Scene

name = "interaction"
order = 35.0


@dataclass(frozen=True, slots=True)
class Parameters:
    """A grid of density and velocity about the strands; with children, a strand stands for as many as are drawn."""

    density: float | None = number(
        None, above=0, unit="1/m²",
        doc="greatest density, strands per square metre across them; absent: the greatest as emitted",
    )  # fmt: skip
    friction: float = number(
        0.05, low=0, high=1,
        doc="fraction of its relative velocity that a strand loses in 0.01 s, at full density",
    )  # fmt: skip
    cell: float | None = number(None, above=0, unit="m", doc="size of a grid cell; absent: 1/32 of the groom's size")


def check(parameters: Parameters, scene: Scene) -> Iterable[tuple[str, str]]:
    """Faults that only the whole scene shows."""
    mine = [use for use in scene.rules if use.name == name]
    if len(mine) > 1 and parameters is not mine[0].parameters:
        yield "", "strands have one grid: list interaction once"


def passes(parameters: Parameters, scene: Scene) -> list[Pass]:
    """None: rods apply this rule in their own step."""
    return []
