"""Where things are at a moment: keys, easing, and poses, in plain Python.

A pose maps a point x of a thing's own frame to rotation · x + translation. Rotations are written as Euler angles in
degrees about x, then y, then z (fixed axes), so the matrix is Rz · Ry · Rx. Angles are interpolated each by itself, in
degrees: from 0 to 720 turns twice.

Sines and cosines are polynomials of our own, because those of the C library differ in the last bit between machines.
"""

from __future__ import annotations

import functools
import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeVar

from .fields import Vector
from .model import Camera, CameraKey, Emitter, PoseKey, Scene, Solid

Matrix = tuple[Vector, Vector, Vector]
"""Three rows."""


class Pose(NamedTuple):
    """A rigid motion: x -> rotation · x + translation (metres)."""

    rotation: Matrix
    translation: Vector


class View(NamedTuple):
    """The camera at a moment: eye and target in metres, vertical field of view in degrees, height in metres."""

    position: Vector
    target: Vector
    fov: float
    height: float


_latest: tuple[Emitter | None, float, Pose]
_latest = None, 0.0, Pose(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (0.0, 0.0, 0.0))
"""Emitter, time and pose that `emitter_pose` has returned last."""


Key = TypeVar("Key", PoseKey, CameraKey)


def deforming_ground(scene: Scene) -> Any:
    """The settings of the mesh that strands stand on, the emitter's or a solid's, where it deforms; else None."""
    given = scene.emitter.groom
    ground: Any = scene.emitter.shape if given is None else None
    if given is not None and given.on:
        ground = next((one for one in scene.solids if one.name == given.on), None)
    return ground if len(getattr(ground, "deform", ())) > 0 else None


def roots_move(scene: Scene) -> bool:
    """Whether roots move in the emitter's frame where the rule emitter_motion is listed: with a mesh that deforms, or
    as a file of strands says."""
    emitter = scene.emitter
    return (emitter.moving and emitter.followers is not None) or deforming_ground(scene) is not None


def pose_in_emitter(solid: Solid, emitter: Emitter) -> Pose:
    """A solid's pose in the emitter's frame, at the start."""
    if solid.follow == "emitter":
        return own_pose(solid, 0.0)
    outer, pose = emitter_pose(emitter, 0.0), own_pose(solid, 0.0)
    (a, b, c), (d, e, f), (g, h, i) = outer.rotation
    back: Matrix = ((a, d, g), (b, e, h), (c, f, i))
    p, q = pose.translation, outer.translation
    return Pose(multiply(back, pose.rotation), rotate(back, (p[0] - q[0], p[1] - q[1], p[2] - q[2])))


def emitter_pose(emitter: Emitter, time: float) -> Pose:
    """The emitter's pose at ``time`` (seconds)."""
    global _latest
    of, then, pose = _latest
    if of is not emitter or then != time:  # in a step rules, roots and solids all ask for the same
        pose = _pose(emitter.position, emitter.rotation, emitter.keys, time)
        _latest = emitter, time, pose
    return pose


def solid_pose(solid: Solid, emitter: Emitter, time: float, outer: Pose | None = None) -> Pose:
    """A solid's pose in the world at ``time`` (seconds); where it follows the emitter, its own is in that frame, whose
    pose then may be given as ``outer``."""
    own = own_pose(solid, time)
    return compose(outer or emitter_pose(emitter, time), own) if solid.follow == "emitter" else own


def own_pose(solid: Solid, time: float) -> Pose:
    """A solid's pose at ``time`` (seconds) in the world, or in the frame of the emitter that it follows."""
    return _pose(solid.position, solid.rotation, solid.keys, time)


def camera_at(camera: Camera, time: float) -> View:
    """The camera's view at ``time`` (seconds). What a key leaves out is the camera's own."""
    if not camera.keys:
        return View(camera.position, camera.target, camera.fov, camera.height)
    before, after, share = _between(camera.keys, time)
    first, second = camera_key(camera, before), camera_key(camera, after)
    return View(
        _mix_vector(first.position, second.position, share),
        _mix_vector(first.target, second.target, share),
        _mix(first.fov, second.fov, share),
        _mix(first.height, second.height, share),
    )


def camera_key(camera: Camera, key: CameraKey) -> View:
    """The view at a key, completed from the camera itself."""
    return View(
        camera.position if key.position is None else key.position,
        camera.target if key.target is None else key.target,
        camera.fov if key.fov is None else key.fov,
        camera.height if key.height is None else key.height,
    )


def compose(outer: Pose, inner: Pose) -> Pose:
    """The pose that first applies ``inner``, then ``outer``."""
    return Pose(multiply(outer.rotation, inner.rotation), apply(outer, inner.translation))


def apply(pose: Pose, point: Vector) -> Vector:
    """A point (3,) of the pose's own frame, in the frame outside."""
    turned = rotate(pose.rotation, point)
    return (turned[0] + pose.translation[0], turned[1] + pose.translation[1], turned[2] + pose.translation[2])


def rotate(matrix: Matrix, vector: Vector) -> Vector:
    """matrix · vector."""
    x, y, z = vector
    a, b, c = matrix
    return (a[0] * x + a[1] * y + a[2] * z, b[0] * x + b[1] * y + b[2] * z, c[0] * x + c[1] * y + c[2] * z)


def multiply(left: Matrix, right: Matrix) -> Matrix:
    """left · right."""
    (a, b, c), (d, e, f), (g, h, i) = right
    (p, q, r), (s, t, u), (v, w, x) = left
    return (
        (p * a + q * d + r * g, p * b + q * e + r * h, p * c + q * f + r * i),
        (s * a + t * d + u * g, s * b + t * e + u * h, s * c + t * f + u * i),
        (v * a + w * d + x * g, v * b + w * e + x * h, v * c + w * f + x * i),
    )


@functools.lru_cache(maxsize=256)  # what stands still, and what follows the emitter, asks again and again
def rotation_matrix(degrees: Vector) -> Matrix:
    """Rz · Ry · Rx of three angles in degrees. Quarter turns are exact."""
    (sx, cx), (sy, cy), (sz, cz) = (sine_cosine(angle) for angle in degrees)
    return (
        (cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx),
        (sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx),
        (-sy, cy * sx, cy * cx),
    )


TAYLOR = tuple((float(n * (n - 1)), float((n - 1) * (n - 2))) for n in range(17, 1, -2))
"""Quotients of one term of a sine's series and of a cosine's to the next, the last ones first; at pi / 4 the first term
left out is below 1e-17."""


def sine_cosine(degrees: float) -> tuple[float, float]:
    """Sine and cosine of an angle in degrees, to 1e-15, the same bits on every machine."""
    if degrees == 0.0:  # as most are
        return degrees, 1.0
    quarter = math.floor(degrees / 90.0 + 0.5)
    # the difference is exact for all angles that a preset may hold; |x| <= pi / 4
    x = (degrees - 90.0 * quarter) * (math.pi / 180.0)
    square = x * x
    sine, cosine = 1.0, 1.0
    for odd, even in TAYLOR:
        sine = 1.0 - square * sine / odd
        cosine = 1.0 - square * cosine / even
    sine *= x
    return ((sine, cosine), (cosine, -sine), (-sine, -cosine), (-cosine, sine))[quarter % 4]


def _pose(position: Vector, rotation: Vector, keys: Sequence[PoseKey], time: float) -> Pose:
    """The pose of a thing that stands at position and rotation, or moves by its keys."""
    if not keys:
        return Pose(rotation_matrix(rotation), position)
    before, after, share = _between(keys, time)
    return Pose(
        rotation_matrix(_mix_vector(before.rotation, after.rotation, share)),
        _mix_vector(before.position, after.position, share),
    )


def _between(keys: Sequence[Key], time: float) -> tuple[Key, Key, float]:
    """The keys on both sides of ``time`` and the eased share between them; clamped outside of all keys."""
    if time <= keys[0].time:
        return keys[0], keys[0], 0.0
    place = bisect_right(keys, time, key=lambda key: key.time)
    if place == len(keys):
        return keys[-1], keys[-1], 0.0
    before, after = keys[place - 1], keys[place]
    return before, after, EASES[before.ease]((time - before.time) / (after.time - before.time))


EASES: dict[str, Callable[[float], float]] = {
    "smooth": lambda share: share * share * (3.0 - 2.0 * share), "linear": lambda share: share,
    "step": lambda share: 0.0,
}  # fmt: skip


def _mix(a: float, b: float, share: float) -> float:
    return a if share == 0.0 else a + (b - a) * share


def _mix_vector(a: Vector, b: Vector, share: float) -> Vector:
    return (_mix(a[0], b[0], share), _mix(a[1], b[1], share), _mix(a[2], b[2], share))
