"""What does not go together with strands from a file, and in the solver `rod`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .faults import Finding, hint, shown
from .fields import settings_of
from .model import Emitter, MeshShape, Scene
from .model.emitter import FILE_LEAVES, GUIDED_LEAVES, HEADS
from .model.placed import both_sizes
from .motion import deforming_ground

PLACE = "emitter.groom"


def clashes(scene: Scene) -> Iterator[Finding]:
    """All that a scene with ``emitter.groom`` may not have, and what needs one. What has its default is no clash."""
    given, fit = scene.emitter.groom, scene.camera.fit
    if scene.camera.file and scene.camera.keys:
        yield Finding(
            ("camera.file", "camera.keys"), "a camera with keys stands where they say; take one of the two out"
        )
    if scene.camera.name and not scene.camera.file:
        yield Finding(("camera.name", "camera.file"), "names a camera of camera.file; there is none: take it out")
    if given is None:
        for key in ("frames", "fps"):
            if getattr(scene.time, key) == 0:
                yield Finding(
                    (f"time.{key}", PLACE), f"0 is as a file of strands says; there is no {PLACE}: write a number"
                )
        if fit is not None:
            yield Finding(
                ("camera.fit", PLACE), f"fits strands of a file into the picture; there is no {PLACE}: take it out"
            )
        return
    if not given.file:
        yield Finding((f"{PLACE}.file",), "must be the path of a file of strands")
    keys = [key for key in grown(scene) if getattr(scene.emitter, key) != settings_of(Emitter)[key].spec.default]
    if keys:
        fewer = f"; --strands, or {PLACE}.strands, draws fewer" if "strands" in keys else ""
        if "particles" in keys:
            fewer += "; particles are those of guides, which there are where rules move strands"
        yield Finding(
            tuple(f"emitter.{key}" for key in keys),
            f"beside {PLACE} an emitter has position, rotation and keys alone, the rest is in the file: take out "
            f"{', '.join(keys)}, or set {'each' if len(keys) > 1 else 'it'} to null{fewer}",
        )
    if scene.children is not None:
        yield Finding(
            ("children", PLACE), "grow about strands of the emitter, not those of a file; take one of the two out"
        )
    yield from both_sizes(PLACE, given)
    if given.on:
        yield from _head(given.on, scene)
    if fit is not None and scene.camera.keys:
        yield Finding(
            ("camera.fit", "camera.keys"), "a camera with keys stands where they say; take one of the two out"
        )


def _head(name: str, scene: Scene) -> Iterator[Finding]:
    """There is a solid of that name, of a kind that hair can be put on."""
    known = {solid.name: solid for solid in scene.solids if solid.name}
    if name not in known:
        yield Finding(
            (f"{PLACE}.on", "solids"), f"no solid has the name {shown(name)}; {hint(name, known, 'the names are')}"
        )
    elif known[name].kind not in HEADS:
        message = f"{shown(name)} is a {known[name].kind}; hair is put on {', '.join(HEADS)}"
        yield Finding((f"{PLACE}.on", "solids"), message)


def mesh_clashes(scene: Scene) -> Iterator[Finding]:
    """All that solids and emitters that are meshes lack or have twice."""
    if isinstance(scene.emitter.shape, MeshShape):
        yield from both_sizes("emitter.shape", scene.emitter.shape)
    for index, solid in enumerate(scene.solids):
        place = f"solids.{index}"
        if solid.kind != "mesh":
            continue
        settings: Any = solid
        if not settings.file:
            yield Finding((f"{place}.file", place), "must be the path of a mesh: .obj, .ply, .stl, .glb or .gltf")
        for key, one in enumerate(settings.deform):
            if not one.file:
                yield Finding((f"{place}.deform.{key}.file", f"{place}.deform.{key}"), "must be the path of a mesh")
        yield from both_sizes(place, settings)


def rod_clashes(scene: Scene) -> Iterator[Finding]:
    """Settings of ``rod`` that have no meaning beside others."""
    if scene.solver != "rod":
        return
    rod, listed = scene.rod, {use.name for use in scene.rules}
    if rod.root == "hinged" and rod.rest == "sag_free":
        yield Finding(
            ("rod.root", "rod.rest"),
            "hinged roots cannot balance gravity, as rest: sag_free needs; use root: clamped, or rest: shape",
        )
    if rod.end == "pinned" and "emitter_motion" in listed and deforming_ground(scene) is not None:
        yield Finding(
            ("rod.end", "emitter", "rules"), "tips cannot be pinned on an emitter that deforms; use end: free"
        )


def grown(scene: Scene) -> list[str]:
    """Settings of an emitter that grows its strands, which those of a file bring along in this scene."""
    held = (*FILE_LEAVES, *GUIDED_LEAVES) if scene.guided else FILE_LEAVES
    return [key for key in settings_of(Emitter) if key not in held]
