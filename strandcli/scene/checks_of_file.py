"""What does not go together with strands from a file."""

from __future__ import annotations

from collections.abc import Container, Iterator

from .fields import settings_of
from .model import Emitter, Scene
from .model.emitter import FILE_LEAVES

PLACE = "emitter.groom"


def clashes(scene: Scene, written: Container[str]) -> Iterator[tuple[str, str]]:
    """Path and message of all that a scene with ``emitter.groom`` may not have, and of what needs one. ``written``:
    paths that were given."""
    if scene.emitter.groom is None:
        if scene.camera.fit is not None:
            yield "camera.fit", "fits strands of a file into the picture, and there is no emitter.groom; take it out"
        return
    if not scene.emitter.groom.file and f"{PLACE}.file" not in written:
        yield f"{PLACE}.file", "must be the path of a file of strands"
    keys = [key for key in settings_of(Emitter) if key not in FILE_LEAVES and f"emitter.{key}" in written]
    if keys:
        fewer = f"; {PLACE}.strands draws fewer" if "strands" in keys else ""
        yield f"emitter.{keys[0]}", (
            f"beside {PLACE} an emitter has position, rotation and keys alone, the rest is in the file: take out "
            f"{', '.join(keys)}, or set {'each' if len(keys) > 1 else 'it'} to null{fewer}"
        )
    if scene.children is not None:
        yield "children", f"grow about strands of the emitter, not about those of a file; take it out, or {PLACE}"
    if scene.emitter.groom.size is not None and f"{PLACE}.scale" in written:
        yield f"{PLACE}.scale", f"clashes with {PLACE}.size, which tells the same; set one of the two to null"
    rules = [use.path for use in scene.rules if use.name != "emitter_motion"]
    if rules:
        yield rules[0], (
            "strands of a file are drawn as they are, and only emitter_motion carries them; take out "
            f"{', '.join(rules)}, or set rules to null"
        )
    if scene.camera.fit is not None and scene.camera.keys:
        yield "camera.fit", "a camera with keys stands where they say; take one of the two out"
