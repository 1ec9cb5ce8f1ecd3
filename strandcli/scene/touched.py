"""Which solids of a scene strands touch."""

from __future__ import annotations

from typing import Any

from .model import Scene


def chosen(parameters: Any, scene: Scene) -> list[Any]:
    """The solids that a collision rule of these parameters acts on: those that it names, or all."""
    return [solid for solid in scene.solids if not parameters.with_ or solid.name in parameters.with_]


def touched(scene: Scene) -> list[Any]:
    """The solids that any of a scene's collision rules acts on, each once."""
    found = {
        id(solid): solid for use in scene.rules if use.name == "collision" for solid in chosen(use.parameters, scene)
    }
    return list(found.values())
