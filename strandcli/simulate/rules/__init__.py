"""The rules that move particles, one file each (thesis §2), and the registry that presets look them up in.

A rule is a module or object with

* ``name`` — what a preset writes;
* ``order`` — its place in the default order, used where a preset gives rules as a mapping;
* ``Parameters`` — a frozen dataclass made of the helpers of `strandcli.scene.fields`;
* ``passes(parameters, scene)`` — the list of `Pass` that a scene needs: what it does not need is neither run nor
  compiled.

A `Pass` names a plain Python function that gives a particle its new place; the composer compiles it, and makes one loop
of those that follow each other (see `strandcli.simulate.thesis.solver`).

A rule may also have ``idle(parameters, scene)``, which says in words why it has nothing to do (or returns ""),
``check(parameters, scene)``, which yields (path, message) for faults that only the whole scene shows, and
``closing(parameters, scene)``, passes that come after those of all rules.

Rules from elsewhere are found by the entry-point group ``strandcli.rules``, or are added with `register`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ...common.registry import load, offered
from ...errors import UsageError
from . import collision, contact, elasticity, emitter_motion, gravity, interaction, stiffness, wind
from .rule import Moment, Pass

if TYPE_CHECKING:
    from ...scene.model import Scene

__all__ = ["Moment", "Pass", "idle", "passes_of", "register", "registry"]

_registry: dict[str, Any] = {
    rule.name: rule for rule in (emitter_motion, gravity, wind, stiffness, collision, elasticity, interaction, contact)
}
_searched = False
GROUP = "strandcli.rules"


def register(rule: Any) -> None:
    """Add a rule for this process. Raises `UsageError` where it lacks a part or where its name is taken."""
    for part in ("name", "order", "Parameters", "passes"):
        if not hasattr(rule, part):
            raise UsageError(f"rule {getattr(rule, 'name', rule)!r}: has no `{part}` (see strandcli.simulate.rules)")
    if _registry.get(rule.name, rule) is not rule:
        raise UsageError(f"rule {rule.name!r}: another rule has this name")
    _registry[rule.name] = rule


def registry() -> Mapping[str, Any]:
    """Every known rule by name, those of installed packages included."""
    global _searched
    if not _searched:
        _searched = True
        for entry in offered(GROUP):
            register(load(entry, "rule"))
    return _registry


def idle(use: Any, scene: Scene) -> str:
    """Why an entry of a scene's rules has nothing to do; "" where it has."""
    return str(getattr(registry()[use.name], "idle", lambda parameters, scene: "")(use.parameters, scene))


def passes_of(scene: Scene) -> list[tuple[Any, Pass]]:
    """The passes of a scene's step in their order, each with the rule's entry that it is of: of every rule that has
    something to do, and then those that close the step."""
    uses = [use for use in scene.rules if not idle(use, scene)]
    found = [(use, one) for use in uses for one in registry()[use.name].passes(use.parameters, scene)]
    closing = [(use, getattr(registry()[use.name], "closing", None)) for use in uses]
    return found + [(use, one) for use, ask in closing if ask for one in ask(use.parameters, scene)]
