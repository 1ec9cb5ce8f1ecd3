"""What the scene has to know about a rule in order to read it from a preset: nothing about how it moves anything."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from .model import Scene

Check = Callable[[Any, "Scene"], Iterable[tuple[str, str]]]
"""(parameters, scene) -> (path inside the parameters, message) of everything that does not fit the scene."""


APPLIED_BY = {"rod": ("emitter_motion", "gravity", "wind", "interaction", "contact", "collision")}
"""Rules that a solver applies, where it does not apply all."""
ONLY_BY = {"interaction": "rod", "contact": "rod"}
"""Rules that a single solver applies."""
MUTUAL = ("interaction", "contact")
"""Rules by which strands act on each other: the motion of each depends on all that are simulated."""
OWN_OF = {"rod": ("elasticity", "stiffness")}
"""Rules in whose place a solver has something better of its own: they may stand in a preset, and are left out."""


def refusal(name: str, solver: str) -> str:
    """Why a solver cannot have a rule; "" where it can, or leaves it out."""
    if ONLY_BY.get(name, solver) != solver:
        return (
            f"the solver {solver} does not apply this rule, for its strands have no velocity; take it out, or use "
            f"solver: {ONLY_BY[name]}"
        )
    if solver not in APPLIED_BY or name in APPLIED_BY[solver] + OWN_OF[solver]:
        return ""
    return (
        f"the solver {solver} does not apply this rule, only {', '.join(APPLIED_BY[solver])}; take it out, or use "
        "solver: thesis"
    )


class RuleType(Protocol):
    """A kind of rule: any object or module with these names.

    ``Parameters`` is a frozen dataclass whose fields are made with the helpers of `fields.py`. ``order`` is the rule's
    place in the default order (rules written as a mapping), ascending.

    Two more are used where they exist. ``check`` (see `Check`) finds parameters that are fine in themselves but not in
    this scene, such as the name of a solid that is not there. ``doc`` describes the rule; without it the first
    paragraph of its ``__doc__`` does.
    """

    name: str
    order: float
    Parameters: type


def doc_of(rule: RuleType) -> str:
    """The rule's description on one line."""
    return getattr(rule, "doc", "") or first_paragraph(rule.__doc__)


def first_paragraph(doc: str | None) -> str:
    """The first paragraph of a docstring, on one line."""
    return " ".join((doc or "").strip().split("\n\n")[0].split())


def chosen(parameters: Any, scene: Scene) -> list[Any]:
    """The solids that a collision rule of these parameters acts on: those that it names, or all."""
    return [solid for solid in scene.solids if not parameters.with_ or solid.name in parameters.with_]


def touched(scene: Scene) -> list[Any]:
    """The solids that any of a scene's collision rules acts on, each once."""
    found = {
        id(solid): solid for use in scene.rules if use.name == "collision" for solid in chosen(use.parameters, scene)
    }
    return list(found.values())
