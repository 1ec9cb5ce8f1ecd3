"""What can be wrong with a scene although each of its settings is fine by itself."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from .faults import Finding, hint, shown
from .fields import Vector, settings_of
from .model import AOVS, Camera, CameraKey, Emitter, Image, MeshKey, MeshShape, PoseKey, Scene, SphereShape
from .model.emitter import FILE_LEAVES, GUIDED_LEAVES, HEADS
from .motion import camera_key, deforming_ground
from .specs import SMALLEST

CLOSEST_PARTICLES = 1e-6
"""Metres. Positions near 1 m are stored in single precision to about 1e-7 m."""
PLACE = "emitter.groom"

_PARALLEL = 1e-6
"""Sine of the angle below which two directions are parallel."""


def findings(scene: Scene) -> Iterator[Finding]:
    """Everything wrong with ``scene`` that no single setting shows, rules' own checks apart."""
    emitter, camera = scene.emitter, scene.camera
    yield from (Finding(places, message) for holds, places, message in clashes(scene) if holds)
    yield from _of_file(scene)
    yield from _tie(emitter)
    yield from _camera(camera)
    yield from _picture(scene.image)
    if isinstance(emitter.shape, MeshShape):
        yield from _mesh(emitter.shape, "emitter.shape", "")
    clumps = () if scene.children is None else scene.children.clumps
    for index in range(1, len(clumps)):
        here, before = (f"children.clumps.{one}.size" for one in (index, index - 1))
        if clumps[index].size >= clumps[index - 1].size:
            wide = f"{clumps[index].size:g} m comes after {clumps[index - 1].size:g} m"
            message = f"locks must be listed from wide to narrow: {wide}"
            yield Finding((here, "children.clumps"), message, (here, before))
    first: dict[str, int] = {}
    for index, solid in enumerate(scene.solids):
        path = f"solids.{index}"
        if solid.name and solid.name in first:
            message = f"solids.{first[solid.name]} has the name {shown(solid.name)} too; names must differ"
            yield Finding((f"{path}.name",), message, (f"{path}.name", f"solids.{first[solid.name]}.name"))
        first.setdefault(solid.name, index)
        yield from _times(solid.keys, f"{path}.keys")
        if solid.kind == "mesh":
            yield from _mesh(solid, path, ": .obj, .ply, .stl, .glb or .gltf")
    yield from _times(emitter.keys, "emitter.keys")
    yield from _times(camera.keys, "camera.keys")


def clashes(scene: Scene) -> Iterator[tuple[bool, tuple[str, ...], str]]:
    """Settings that do not go together: whether a scene has them, their paths, and the message."""
    emitter, camera, rod, given = scene.emitter, scene.camera, scene.rod, scene.emitter.groom
    apart = emitter.length / (emitter.particles - 1)
    combed = "strands that are tied are combed to their tie; take one of the two out"
    keyed = "a camera with keys stands where they say; take one of the two out"
    is_rod, listed = scene.solver == "rod", {use.name for use in scene.rules}
    yield (
        given is None and apart < CLOSEST_PARTICLES, ("emitter.length", "emitter.particles"),
        f"{emitter.particles} particles on {emitter.length:g} m stand {apart:.2g} m apart, too close for single "
        f"precision (at least {CLOSEST_PARTICLES:g} m); take fewer particles or longer strands",
    )  # fmt: skip
    for key in ("direction", "comb", "parting", "shape.comb"):
        owner: Any = emitter.shape if key == "shape.comb" else emitter
        own = getattr(owner, key.rpartition(".")[2], None)
        yield emitter.tie is not None and own not in (None, ""), (f"emitter.{key}", "emitter.tie"), combed
    yield bool(camera.file and camera.keys), ("camera.file", "camera.keys"), keyed
    yield (
        bool(camera.name and not camera.file), ("camera.name", "camera.file"),
        "names a camera of camera.file; there is none: take it out",
    )  # fmt: skip
    for key in ("frames", "fps"):
        message = f"0 is as a file of strands says; there is no {PLACE}: write a number"
        yield given is None and getattr(scene.time, key) == 0, (f"time.{key}", PLACE), message
    fits = f"fits strands of a file into the picture; there is no {PLACE}: take it out"
    yield given is None and camera.fit is not None, ("camera.fit", PLACE), fits
    yield given is not None and camera.fit is not None and bool(camera.keys), ("camera.fit", "camera.keys"), keyed
    grow = "grow about strands of the emitter, not those of a file; take one of the two out"
    yield given is not None and scene.children is not None, ("children", PLACE), grow
    lens = "an orthographic camera has no lens; make the camera perspective, or the aperture 0"
    yield camera.aperture > 0 and camera.kind == "orthographic", ("camera.aperture", "camera.kind"), lens
    picture = "must be the path of a lat-long picture, PNG, JPEG or .hdr"
    yield scene.environment is not None and not scene.environment.image, ("environment.image",), picture
    hinged = "hinged roots cannot balance gravity, as rest: sag_free needs; use root: clamped, or rest: shape"
    yield is_rod and rod.root == "hinged" and rod.rest == "sag_free", ("rod.root", "rod.rest"), hinged
    carried = is_rod and rod.end == "pinned" and "emitter_motion" in listed
    pinned = "tips cannot be pinned on an emitter that deforms; use end: free"
    yield carried and deforming_ground(scene) is not None, ("rod.end", "emitter", "rules"), pinned


def grown(scene: Scene) -> list[str]:
    """Settings of an emitter that grows its strands, which those of a file bring along in this scene."""
    leaves = (*FILE_LEAVES, *GUIDED_LEAVES) if scene.guided else FILE_LEAVES
    return [key for key in settings_of(Emitter) if key not in leaves]


def _of_file(scene: Scene) -> Iterator[Finding]:
    """What ``emitter.groom`` lacks or has twice, and what is set beside it; what has its default is no clash."""
    given = scene.emitter.groom
    if given is None:
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
    yield from _both_sizes(PLACE, given)
    kinds = {solid.name: solid.kind for solid in scene.solids if solid.name}
    if given.on and given.on not in kinds:
        message = f"no solid has the name {shown(given.on)}; {hint(given.on, kinds, 'the names are')}"
        yield Finding((f"{PLACE}.on", "solids"), message)
    elif given.on and kinds[given.on] not in HEADS:
        message = f"{shown(given.on)} is a {kinds[given.on]}; hair is put on {', '.join(HEADS)}"
        yield Finding((f"{PLACE}.on", "solids"), message)


def _mesh(mesh: Any, path: str, formats: str) -> Iterator[Finding]:
    """What a mesh at a path lacks or has twice."""
    if not mesh.file:
        of_emitter = ("emitter.shape",) if path == "emitter.shape" else ()
        words = "a mesh of triangles" if of_emitter else f"a mesh{formats}"
        yield Finding((f"{path}.file", path), f"must be the path of {words}", of_emitter)
    for index, key in enumerate(mesh.deform):
        if not key.file:
            place = f"{path}.deform.{index}"
            yield Finding((f"{place}.file", place), "must be the path of a mesh", (place,))
    yield from _times(mesh.deform, f"{path}.deform")
    yield from _both_sizes(path, mesh)


def _both_sizes(path: str, given: Any) -> Iterator[Finding]:
    """The clash of a scale and a size where settings at a path have both."""
    if given.size is not None and given.scale is not None:
        message = f"clashes with {path}.size, which sets the same; set one to null"
        yield Finding((f"{path}.scale", f"{path}.size"), message)


def _tie(emitter: Emitter) -> Iterator[Finding]:
    """The tie is above the surface that bears the strands, and bundles leave it outward."""
    tie = emitter.tie
    if tie is None:
        return
    own, (x, y, z) = ("emitter.tie.position", "emitter.tie", "emitter.shape"), tie.position
    away = math.hypot(x, y, z)
    if not isinstance(emitter.shape, SphereShape | MeshShape):
        yield Finding(("emitter.tie", "emitter.shape"), "strands are tied on a sphere or a mesh; take another shape")
        return
    cap = emitter.shape.cap if isinstance(emitter.shape, SphereShape) else 180.0
    if away < SMALLEST or (cap < 180 and math.atan2(math.hypot(x, z), y) >= math.radians(cap)):
        yield Finding(own, "the tie is above no place of the emitter's surface that strands grow from; move it there")
    elif tie.direction is not None and _dot(tie.direction, tie.position) <= 1e-3 * away * math.hypot(*tie.direction):
        path = "emitter.tie.direction"
        yield Finding((path,), "points into the emitter's surface; turn it outward", (path, *own))


def _times(keys: Sequence[PoseKey | CameraKey | MeshKey], path: str) -> Iterator[Finding]:
    for index in range(1, len(keys)):
        before, after = keys[index - 1].time, keys[index].time
        here = f"{path}.{index}.time"
        if after <= before:
            message = f"keys must go forward in time: {after:g} s comes after {before:g} s"
            yield Finding((here,), message, (here, f"{path}.{index - 1}.time"))


def _camera(camera: Camera) -> Iterator[Finding]:
    """The camera looks somewhere, and not along its up direction: itself, at each key and between keys."""
    own = ("camera.position", "camera.target", "camera.up")
    if problem := _blind(_minus(camera.target, camera.position), camera):
        yield Finding(("camera.target", "camera.position", "camera.up"), problem, own)
    views = [camera_key(camera, key) for key in camera.keys]
    looks = [_minus(view.target, view.position) for view in views]
    for index, look in enumerate(looks):
        places = (f"camera.keys.{index}.target", f"camera.keys.{index}.position")
        if problem := _blind(look, camera):
            yield Finding(places, problem, (*own, *places))
        elif index and camera.keys[index - 1].ease != "step" and not _blind(looks[index - 1], camera):
            before = (f"camera.keys.{index - 1}.position", f"camera.keys.{index - 1}.target")
            if problem := _blind_between(looks[index - 1], look, camera):
                yield Finding(places, problem, (*own, *places, *before))


def _picture(image: Image) -> Iterator[Finding]:
    x, y, width, height = image.crop or (0, 0, 1, 1)
    if x + width > image.size[0] or y + height > image.size[1]:
        message = f"the window {width}x{height}+{x}+{y} reaches beyond the picture of {image.size[0]}x{image.size[1]}"
        yield Finding(("image.crop", "image.size"), message)
    for index, name in enumerate(image.aovs):
        places = (f"image.aovs.{index}", "image.aovs")
        if name not in AOVS:
            yield Finding(places, f"unknown layer {shown(name)}; {hint(name, AOVS, 'the layers are')}")
        elif name in image.aovs[:index]:
            yield Finding(places, f"the layer {shown(name)} is listed twice")


def _blind(look: Vector, camera: Camera) -> str:
    """Why a camera that looks along ``look`` sees nothing, or nothing at all."""
    reach = math.hypot(*look)
    if reach < 1e-6:
        return "the camera stands at its own target; it has to look somewhere else"
    if math.hypot(*_cross(camera.up, look)) < _PARALLEL * reach * math.hypot(*camera.up):
        return "the camera looks along `up`; turn `up` aside"
    return ""


def _blind_between(before: Vector, after: Vector, camera: Camera) -> str:
    """The same on the straight path from one look to the next."""
    longest = max(math.hypot(*before), math.hypot(*after))
    if _least(before, after) < _PARALLEL * longest:
        return "between this key and the one before, the camera passes through its own target"
    if _least(_cross(camera.up, before), _cross(camera.up, after)) < _PARALLEL * longest * math.hypot(*camera.up):
        return "between this key and the one before, the camera looks along `up`; turn `up` aside or add a key"
    return ""


def _least(a: Vector, b: Vector) -> float:
    """Least distance from the origin to the line segment from a to b."""
    along = _minus(b, a)
    square = _dot(along, along)
    share = 0.0 if square == 0.0 else min(max(-_dot(a, along) / square, 0.0), 1.0)
    return math.hypot(*(p + share * w for p, w in zip(a, along, strict=True)))


def _minus(a: Vector, b: Vector) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
