"""Points of view: the scene's camera, and the lights' own views for their shadow maps."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...scene.model import Camera
from ...scene.motion import camera_at
from ..common.kernels import view_columns as columns
from ..common.kernels.view_columns import DepthSlope

CORNER_SIDES = np.array(np.meshgrid(*[[0, 1]] * 3)).reshape(3, -1)
"""(3, 8) of each axis and corner of a box: 0 at its lower side, 1 at its upper one."""
CORNER_AXES = np.arange(3)[:, None]


@dataclass(frozen=True)
class View:
    """A rigid transform and a projection onto ``width`` × ``height`` pixels."""

    eye: NDArray[np.float64]
    right: NDArray[np.float64]
    up: NDArray[np.float64]
    forward: NDArray[np.float64]
    perspective: bool
    focal: float
    """Pixels a metre: at a depth of one metre (perspective) or anywhere (orthographic)."""
    near: float
    far: float
    width: float
    height: float
    centre: tuple[float, float] | None = None
    """Pixel on the view's axis; None: the centre of the screen. It differs for crop windows and points of a lens."""
    window: tuple[float, float, float, float] | None = None
    """Of a part of a view: how far from the whole's upper left it begins, and the whole's width and height, pixels."""

    def cropped(self, x: float, y: float, width: float, height: float) -> View:
        """Return the part of this view that begins x and y pixels from the upper left."""
        cx, cy = self.middle
        left, top, *whole = self.window or (0.0, 0.0, self.width, self.height)
        return replace(
            self, width=width, height=height, centre=(cx - x, cy - y), window=(left + x, top + y, whole[0], whole[1])
        )

    @property
    def whole(self) -> View:
        """The view of which this one is a part, or this one."""
        if self.window is None:
            return self
        (cx, cy), (left, top, width, height) = self.middle, self.window
        return replace(self, width=width, height=height, centre=(cx + left, cy + top), window=None)

    def shifted(self, x: float, y: float) -> View:
        """Return this view with its picture moved by x and y pixels."""
        cx, cy = self.middle
        return replace(self, centre=(cx + x, cy + y))

    def through(self, right: float, up: float, focus: float) -> View:
        """Return the view from a point of a thin lens, ``right`` and ``up`` metres from its centre. Points at the depth
        ``focus`` keep their position on the screen; at a depth z they move by focal · (1 / focus − 1 / z) · offset."""
        cx, cy = self.middle
        shift = self.focal / focus
        return replace(
            self,
            eye=self.eye + right * self.right + up * self.up,
            centre=(cx + shift * right, cy - shift * up),
        )

    @property
    def middle(self) -> tuple[float, float]:
        """Pixel on the view's axis."""
        return self.centre or (self.width / 2, self.height / 2)

    @property
    def depth_slope(self) -> DepthSlope:
        """Growth of depth numbers over the length of a pixel toward the eye."""
        x, y = (np.float32(c) for c in self.middle)
        if self.perspective:
            return DepthSlope(np.float32(1 / self.focal), np.float32(0), x, y)
        return DepthSlope(np.float32(0), np.float32(1 / (self.focal * (self.far - self.near))), x, y)

    def pack(self) -> NDArray[np.float32]:
        """Return the columns of `common.kernels.view_columns`, (SIZE,) float32; cached, so do not write to it."""
        return self._packed

    @cached_property
    def _packed(self) -> NDArray[np.float32]:
        out = np.zeros(columns.SIZE, np.float64)
        for first, axis in (
            (columns.RIGHT_X, self.right), (columns.UP_X, self.up), (columns.FORWARD_X, self.forward)
        ):  # fmt: skip
            out[first : first + 3] = axis
            out[first + 3] = -axis @ self.eye
        middle = np.array(self.middle)
        half = np.maximum(np.array([self.width, self.height]) - middle, middle)
        slant = np.sqrt(1 + (half / self.focal) ** 2) if self.perspective else np.ones(2)
        out[columns.PERSPECTIVE] = self.perspective
        out[columns.FOCAL] = self.focal
        out[columns.NEAR_PLANE] = self.near
        out[[columns.AXIS_X, columns.AXIS_Y]] = middle
        out[[columns.SLANT_X, columns.SLANT_Y]] = slant
        out[columns.DEPTH_RANGE] = self.far - self.near
        out[[columns.EYE_X, columns.EYE_Y, columns.EYE_Z]] = self.eye
        out[columns.CORNER_STRETCH] = np.sqrt(1 + half @ half / self.focal**2) if self.perspective else 1.0
        out[[columns.SCREEN_WIDTH, columns.SCREEN_HEIGHT]] = self.width, self.height
        return out.astype(np.float32)


def axes(forward: ArrayLike, up: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return right, up and forward, orthonormal; an ``up`` parallel to the view is replaced by another axis."""
    f: NDArray[np.float64] = np.asarray(forward, np.float64)
    f = f / np.linalg.norm(f)
    u: NDArray[np.float64] = np.asarray(up, np.float64)
    right = cross(f, u)
    if np.linalg.norm(right) < 1e-9 * max(float(np.linalg.norm(u)), 1e-300):
        right = cross(f, np.eye(3)[np.argmin(np.abs(f))])
    right = right / np.linalg.norm(right)
    return right, cross(right, f), f


def cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the cross product of two vectors (3,); `numpy.cross` takes ten times as long."""
    x, y, z = a.tolist()
    u, v, w = b.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


def corners_of(bounds: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the corners (8, 3) of a box (2, 3)."""
    return bounds[CORNER_SIDES, CORNER_AXES].T


def camera_view(camera: Camera, time: float, width: int, height: int, bounds: NDArray[np.float64]) -> View:
    """Return the view of the scene's camera at a time, seconds; ``bounds`` (2, 3): bounding box of the strands, metres,
    for the depth range of an orthographic camera."""
    position, target, fov, tall = camera_at(camera, time)
    eye = np.array(position, np.float64)
    right, up, forward = axes(np.array(target) - eye, camera.up)
    centre = None
    if (camera.axis_x, camera.axis_y) != (0.5, 0.5):
        centre = (camera.axis_x * width, camera.axis_y * height)
    if camera.kind == "perspective":
        focal = height / 2 / np.tan(np.radians(fov) / 2)
        return View(eye, right, up, forward, True, float(focal), camera.near, np.inf, width, height, centre)
    corners = corners_of(bounds)
    # leave room for solids behind the strands, but keep enough depth resolution for the strands
    far = max(float(((corners - eye) @ forward).max()), camera.near) * 1.01 + 100.0 * ball(bounds)[1]
    return View(eye, right, up, forward, False, height / tall, camera.near, far, width, height, centre)


def parallel_view(direction: ArrayLike, size: int, bounds: NDArray[np.float64]) -> View:
    """Return an orthographic view along a directional light that just contains the box ``bounds`` (2, 3), metres."""
    right, up, forward = axes(direction, (0.0, 1.0, 0.0))
    centre, radius = ball(bounds)
    corners = corners_of(bounds) - centre
    # a single strand along the light has an extent of rounding errors only
    extent = max(float(np.abs(corners @ right).max()), float(np.abs(corners @ up).max()), 1e-3 * radius)
    eye = centre - forward * radius * 1.01
    # one texel is left free on every side
    focal = max(size - 2, 1) / (2 * extent)
    return View(eye, right, up, forward, False, focal, 0.0, 2.02 * radius, size, size)


def point_views(position: ArrayLike, size: int, bounds: NDArray[np.float64]) -> list[View]:
    """Return one perspective view of the box for a point light outside, or six, the sides of a cube, for one inside."""
    eye = np.asarray(position, np.float64)
    centre, radius = ball(bounds)
    distance = float(np.linalg.norm(centre - eye))
    if distance > 1.3 * radius:
        half = np.arcsin(radius / distance)
        right, up, forward = axes(centre - eye, (0.0, 1.0, 0.0))
        focal = max(size - 2, 1) / 2 / np.tan(half)
        return [View(eye, right, up, forward, True, float(focal), distance - radius, distance + radius, size, size)]
    near = 1e-4 * max(radius, 1e-20)
    views = []
    for axis in np.concatenate([np.eye(3), -np.eye(3)]):
        right, up, forward = axes(axis, (0.0, 1.0, 0.0))
        views.append(View(eye, right, up, forward, True, max(size - 3, 1) / 2, near, distance + radius, size, size))
    return views


def ball(bounds: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Return centre and radius of the bounding ball of a box."""
    centre = bounds.mean(0)
    return centre, max(float(np.linalg.norm(bounds[1] - bounds[0])) / 2, 1e-12)
