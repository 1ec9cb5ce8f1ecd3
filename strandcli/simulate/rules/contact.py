"""Contact: strands do not pass through each other, and rub on each other, for scenes where few strands matter.

After Daviet et al. 2011. For many strands, rule `interaction` does it cheaper and by the mean.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...scene.fields import integer, number
from .rule import Pass

if TYPE_CHECKING:
    from ...scene.model import Scene

name = "contact"
order = 36.0


@dataclass(frozen=True, slots=True)
class Parameters:
    """Contact with friction, strand against strand; children are not looked at."""

    thickness: float | None = number(
        None, above=0, unit="m", doc="least distance of centre lines; absent: twice rod.radius"
    )
    friction: float = number(0.3, low=0, high=10, doc="Coulomb's coefficient between strands")
    iterations: int = integer(8, low=1, high=100, doc="contact iterations per step, at most; two or three are usual")


def check(parameters: Parameters, scene: Scene) -> Iterable[tuple[str, str]]:
    """Faults that only the whole scene shows."""
    mine = [use for use in scene.rules if use.name == name]
    if len(mine) > 1 and parameters is not mine[0].parameters:
        yield "", "strands have one contact: list contact once"


def passes(parameters: Parameters, scene: Scene) -> list[Pass]:
    """None: rods apply this rule in their own step."""
    return []
