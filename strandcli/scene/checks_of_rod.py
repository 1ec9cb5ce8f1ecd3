"""What does not go together in the solver `rod`."""

from __future__ import annotations

from collections.abc import Iterator

from .checks_of_file import Clash
from .model import Scene
from .motion import deforming_ground


def rod_clashes(scene: Scene) -> Iterator[Clash]:
    """Settings of ``rod`` that have no meaning beside others, one clash for each setting with all that is wrong."""
    found: dict[str, list[Clash]] = {}
    for clash in _clashes(scene):
        found.setdefault(clash[0][0], []).append(clash)
    for mine in found.values():
        paths = dict.fromkeys(path for paths, _ in mine for path in paths)
        yield tuple(paths), "; ".join(message for _, message in mine)


def _clashes(scene: Scene) -> Iterator[Clash]:
    """One by one."""
    if scene.solver != "rod":
        return
    rod, listed = scene.rod, {use.name for use in scene.rules}
    if rod.root == "hinged" and rod.rest == "sag_free":
        yield (
            ("rod.root", "rod.rest"),
            "hinged roots cannot balance gravity, as rest: sag_free needs; use root: clamped, or rest: shape",
        )
    if rod.end == "pinned" and "emitter_motion" in listed and deforming_ground(scene) is not None:
        yield ("rod.end", "emitter", "rules"), "tips cannot be pinned on an emitter that deforms; use end: free"
