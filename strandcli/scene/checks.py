"""What can be wrong with a scene although each of its settings is fine by itself."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

from .checks_of_file import clashes, mesh_clashes, rod_clashes
from .faults import Finding, hint, shown
from .fields import Vector
from .model import (
    AOVS,
    Camera,
    CameraKey,
    Children,
    Emitter,
    Image,
    MeshKey,
    MeshShape,
    PoseKey,
    Scene,
    Solid,
    SphereShape,
    Tie,
)
from .motion import camera_key
from .specs import SMALLEST

CLOSEST_PARTICLES = 1e-6
"""Metres. Positions near 1 m are stored in single precision to about 1e-7 m."""

_PARALLEL = 1e-6
"""Sine of the angle below which two directions are parallel."""


def findings(scene: Scene) -> Iterator[Finding]:
    """Everything wrong with ``scene`` that no single setting shows, rules' own checks apart."""
    if scene.emitter.groom is None:
        yield from _spacing(scene.emitter)
    yield from clashes(scene)
    yield from mesh_clashes(scene)
    yield from rod_clashes(scene)
    yield from _mesh(scene.emitter)
    yield from _tie(scene.emitter)
    yield from _locks(scene.children)
    yield from _times(scene.emitter.keys, "emitter.keys")
    yield from _solid_names(scene.solids)
    for index, solid in enumerate(scene.solids):
        yield from _times(solid.keys, f"solids.{index}.keys")
        yield from _times(getattr(solid, "deform", ()), f"solids.{index}.deform")
    yield from _camera(scene.camera)
    yield from _times(scene.camera.keys, "camera.keys")
    yield from _lens(scene.camera)
    yield from _picture(scene.image)
    if scene.environment is not None and not scene.environment.image:
        yield Finding(("environment.image",), "must be the path of a lat-long picture, PNG, JPEG or .hdr")


def _spacing(emitter: Emitter) -> Iterator[Finding]:
    apart = emitter.length / (emitter.particles - 1)
    if apart < CLOSEST_PARTICLES:
        yield Finding(
            ("emitter.length", "emitter.particles"),
            f"{emitter.particles} particles on {emitter.length:g} m stand {apart:.2g} m apart, too close for single "
            f"precision (at least {CLOSEST_PARTICLES:g} m); take fewer particles or longer strands",
        )


def _mesh(emitter: Emitter) -> Iterator[Finding]:
    """There is a mesh to grow on, and nothing that needs a surface with a formula."""
    if not isinstance(emitter.shape, MeshShape):
        return
    if not emitter.shape.file:
        yield Finding(
            ("emitter.shape.file", "emitter.shape"), "must be the path of a mesh of triangles", ("emitter.shape",)
        )
    yield from _times(emitter.shape.deform, "emitter.shape.deform")
    for index, key in enumerate(emitter.shape.deform):
        path = f"emitter.shape.deform.{index}"
        if not key.file:
            yield Finding((f"{path}.file", path), "must be the path of a mesh", (path,))
    if emitter.tie is not None and emitter.shape.comb:
        places = ("emitter.shape.comb", "emitter.tie")
        yield Finding(places, "strands that are tied are combed to their tie; take one of the two out")


def _tie(emitter: Emitter) -> Iterator[Finding]:
    """Strands can be combed to the tie: it is above the surface that bears them, and nothing else leads them."""
    tie = emitter.tie
    if tie is None:
        return
    own = ("emitter.tie.position", "emitter.tie", "emitter.shape")
    normal = _normal(tie, emitter)
    if not isinstance(emitter.shape, SphereShape | MeshShape):
        yield Finding(("emitter.tie", "emitter.shape"), "strands are tied on a sphere or a mesh; take another shape")
    elif normal is None:
        message = "the tie is above no place of the emitter's surface that strands grow from; move it there"
        yield Finding(own, message)
    elif tie.direction is not None and _dot(tie.direction, normal) <= 1e-3 * math.hypot(*tie.direction):
        path = "emitter.tie.direction"
        yield Finding((path,), "points into the emitter's surface; turn it outward", (path, *own))
    for key in ("direction", "comb", "parting"):
        if getattr(emitter, key) is not None:
            places = (f"emitter.{key}", "emitter.tie")
            yield Finding(places, "strands that are tied are combed to their tie; take one of the two out")


def _normal(tie: Tie, emitter: Emitter) -> Vector | None:
    """The emitter's normal below the tie; None where no strands grow there."""
    shape, (x, y, z) = emitter.shape, tie.position
    away = math.hypot(x, y, z)
    beyond = (
        isinstance(shape, SphereShape)
        and shape.cap < 180
        and math.atan2(math.hypot(x, z), y) >= math.radians(shape.cap)
    )
    return None if beyond or away < SMALLEST else (x / away, y / away, z / away)


def _locks(children: Children | None) -> Iterator[Finding]:
    clumps = () if children is None else children.clumps
    for index in range(1, len(clumps)):
        if clumps[index].size >= clumps[index - 1].size:
            path = f"children.clumps.{index}.size"
            yield Finding(
                (path, "children.clumps"),
                f"locks must be listed from wide to narrow: {clumps[index].size:g} m comes after "
                f"{clumps[index - 1].size:g} m",
                (path, f"children.clumps.{index - 1}.size"),
            )


def _times(keys: Sequence[PoseKey | CameraKey | MeshKey], path: str) -> Iterator[Finding]:
    for index in range(1, len(keys)):
        if keys[index].time <= keys[index - 1].time:
            yield Finding(
                (f"{path}.{index}.time",),
                f"keys must go forward in time: {keys[index].time:g} s comes after {keys[index - 1].time:g} s",
                (f"{path}.{index}.time", f"{path}.{index - 1}.time"),
            )


def _solid_names(solids: Iterable[Solid]) -> Iterator[Finding]:
    first: dict[str, int] = {}
    for index, solid in enumerate(solids):
        path = f"solids.{index}.name"
        if solid.name and solid.name in first:
            message = f"solids.{first[solid.name]} has the name {shown(solid.name)} too; names must differ"
            yield Finding((path,), message, (path, f"solids.{first[solid.name]}.name"))
        first.setdefault(solid.name, index)


def _camera(camera: Camera) -> Iterator[Finding]:
    """The camera looks somewhere, and not along its up direction: itself, at each key and between keys."""
    own = ("camera.position", "camera.target", "camera.up")
    problem = _blind(_minus(camera.target, camera.position), camera)
    if problem:
        yield Finding(("camera.target", "camera.position", "camera.up"), problem, own)
    views = [camera_key(camera, key) for key in camera.keys]
    looks = [_minus(view.target, view.position) for view in views]
    for index, look in enumerate(looks):
        path = f"camera.keys.{index}"
        places = (f"{path}.target", f"{path}.position")
        involves = (*own, *places)
        problem = _blind(look, camera)
        if problem:
            yield Finding(places, problem, involves)
        elif index and camera.keys[index - 1].ease != "step" and not _blind(looks[index - 1], camera):
            problem = _blind_between(looks[index - 1], look, camera)
            if problem:
                before = (f"camera.keys.{index - 1}.position", f"camera.keys.{index - 1}.target")
                yield Finding(places, problem, (*involves, *before))


def _lens(camera: Camera) -> Iterator[Finding]:
    if camera.aperture > 0 and camera.kind == "orthographic":
        message = "an orthographic camera has no lens; make the camera perspective, or the aperture 0"
        yield Finding(("camera.aperture", "camera.kind"), message)


def _picture(image: Image) -> Iterator[Finding]:
    if image.crop is not None:
        x, y, width, height = image.crop
        if x + width > image.size[0] or y + height > image.size[1]:
            message = (
                f"the window {width}x{height}+{x}+{y} reaches beyond the picture of {image.size[0]}x{image.size[1]}"
            )
            yield Finding(("image.crop", "image.size"), message)
    for index, name in enumerate(image.aovs):
        path = f"image.aovs.{index}"
        if name not in AOVS:
            message = f"unknown layer {shown(name)}; {hint(name, AOVS, 'the layers are')}"
            yield Finding((path, "image.aovs"), message)
        elif name in image.aovs[:index]:
            yield Finding((path, "image.aovs"), f"the layer {shown(name)} is listed twice")


def _blind(look: Vector, camera: Camera) -> str:
    """Why a camera that looks along ``look`` sees nothing, or nothing at all."""
    reach = math.hypot(*look)
    if reach < 1e-6:
        return "the camera stands at its own target; it has to look somewhere else"
    if math.hypot(*_cross(camera.up, look)) < _PARALLEL * reach * math.hypot(*camera.up):
        return "the camera looks along `up`; turn `up` aside"
    return ""


def _blind_between(before: Vector, after: Vector, camera: Camera) -> str:
    """The same on the straight way from one look to the next."""
    longest = max(math.hypot(*before), math.hypot(*after))
    if _least(before, after) < _PARALLEL * longest:
        return "between this key and the one before, the camera passes through its own target"
    if _least(_cross(camera.up, before), _cross(camera.up, after)) < _PARALLEL * longest * math.hypot(*camera.up):
        return "between this key and the one before, the camera looks along `up`; turn `up` aside or add a key"
    return ""


def _least(a: Vector, b: Vector) -> float:
    """Least distance from the origin to the line segment from a to b."""
    way = _minus(b, a)
    square = sum(w * w for w in way)
    share = 0.0 if square == 0.0 else min(max(-sum(p * w for p, w in zip(a, way, strict=True)) / square, 0.0), 1.0)
    return math.hypot(*(p + share * w for p, w in zip(a, way, strict=True)))


def _minus(a: Vector, b: Vector) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
