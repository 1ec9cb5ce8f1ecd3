"""What does not go together in the solver `rod`."""

from __future__ import annotations

from collections.abc import Iterator

from .checks_of_file import Clash
from .model import Scene
from .motion import deforming_ground


def rod_clashes(scene: Scene) -> Iterator[Clash]:
    """Settings of ``rod`` that have no meaning beside others."""
    if scene.solver != "rod":
        return
    rod, listed = scene.rod, {use.name for use in scene.rules}
    if rod.root == "hinged" and rod.rest == "sag_free":
        yield (
            ("rod.root", "rod.rest"),
            "hinged roots hold no strand up, as rest: sag_free asks of them; use root: clamped, or rest: shape",
        )
    if rod.end == "pinned" and "emitter_motion" in listed and deforming_ground(scene) is not None:
        yield ("rod.end", "emitter", "rules"), "tips cannot be pinned on an emitter that deforms; use end: free"
    if rod.yield_strain is not None and "contact" in listed:
        yield ("rod.yield_strain", "rules"), "does not go with the rule contact; leave one of them out"
