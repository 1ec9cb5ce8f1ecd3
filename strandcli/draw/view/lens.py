"""Depth of field and motion blur: the lens points and times of the exposures that a picture averages.

A picture is the mean of whole pictures, each through one point of a thin lens at one time (the accumulation buffer of
Haeberli and Akeley 1990), so visibility, shading and shadows are exact for any resolver. Lens points and times follow
an additive recurrence with a random start: each coordinate is evenly distributed alone and jointly with the others
(Roberts 2018, as for roots), the mean is unbiased, and it depends on the seed alone. Pictures in a z-buffer are also
jittered by a fraction of a sample, a different one in each exposure, so that sharp edges are antialiased too.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...constants import W
from ...groom.emit import PLASTIC, stream
from ...scene.model import Camera, Emitter
from ...scene.motion import camera_at, emitter_pose
from .camera import View


class Exposure(NamedTuple):
    """One of the pictures that are averaged."""

    at: float
    """Time, seconds."""
    share: float
    """Time as a fraction, from the previous frame (0) to the frame itself (1)."""
    right: float = 0.0
    up: float = 0.0
    """Point of the lens, metres from its centre."""
    x: float = 0.0
    y: float = 0.0
    """Jitter of the picture, samples, from −1/2 to 1/2."""


def is_sampled(camera: Camera) -> bool:
    """Return whether lens or shutter is open, so that a picture needs several exposures."""
    return camera.aperture > 0 or camera.shutter > 0


def exposures(camera: Camera, seed: int, at: float, fps: float) -> list[Exposure]:
    """Return the exposures of the frame at a time, seconds; a single one through a pinhole if lens and shutter are
    closed.

    The shutter is open from ``at`` − shutter / fps to ``at``; before time 0 nothing moves. Every frame uses the same
    lens points, so that still scenes do not flicker.
    """
    if not is_sampled(camera):
        return [Exposure(at, 1.0)]
    count = camera.samples
    start = stream(seed, 6, 5)
    index = np.arange(count)
    across = concentric((start[0] + index / PLASTIC) % 1.0, (start[1] + index / PLASTIC**2) % 1.0)
    offsets = camera.aperture / 2 * across
    ago = camera.shutter * (1.0 - (index + start[2]) / count)
    # steps √13 and √22 are evenly distributed jointly with the lens points too; many others, such as √2 and √5, are not
    jitter = (start[3:, None] + index * np.sqrt([[13.0], [22.0]])) % 1.0 - 0.5
    return [
        Exposure(max(at - float(late) / fps, 0.0), 1.0 - float(late), float(right), float(up), float(x), float(y))
        for late, (right, up), (x, y) in zip(ago, offsets, jitter.T, strict=True)
    ]


def concentric(u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    """Map points of the unit square to points (n, 2) of the unit disc, preserving areas and neighbourhoods (Shirley and
    Chiu 1997)."""
    a, b = 2 * u - 1, 2 * v - 1
    wide = np.abs(a) > np.abs(b)
    radius = np.where(wide, a, b)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(wide, b / a, np.where(b == 0, 0.0, a / b))
    angle = np.where(wide, np.pi / 4 * ratio, np.pi / 2 - np.pi / 4 * ratio)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], 1)


def focus_of(camera: Camera, at: float) -> float:
    """Return the depth in focus, metres."""
    if camera.focus is not None:
        return camera.focus
    view = camera_at(camera, at)
    return math.dist(view.position, view.target)


def through_lens(view: View, camera: Camera, exposure: Exposure) -> View:
    """Return the view through an exposure's point of the lens, from that through its centre."""
    if camera.aperture == 0:
        return view
    return view.through(exposure.right, exposure.up, focus_of(camera, exposure.at))


def interpolate(
    before: NDArray[np.float32], after: NDArray[np.float32], emitter: Emitter, carried: bool,
    start: float, end: float, exposure: Exposure, out: NDArray[np.float32],
) -> NDArray[np.float32]:  # fmt: skip
    """Return strands (blocks, rows, 3 W) at an exposure's time, interpolated between the times ``start`` and ``end``,
    seconds; written to ``out``.

    Interpolation is linear, in the emitter's frame if it carries the strands, else in the world. Rigid motion with the
    emitter is therefore exact, that of roots above all; otherwise the error is at most |a| (end − start)² / 8, where a
    is the acceleration in that frame.
    """
    share = exposure.share
    first, second = (1 - share) * np.eye(3), share * np.eye(3)
    shift = np.zeros(3)
    if carried and len(emitter.keys) > 1:
        (r0, t0), (r1, t1), (r, t) = (
            (np.array(pose.rotation), np.array(pose.translation))
            for pose in (emitter_pose(emitter, time) for time in (start, end, exposure.at))
        )
        first, second = (1 - share) * r @ r0.T, share * r @ r1.T
        shift = t - first @ t0 - second @ t1
    sides = (moved.reshape(*moved.shape[:2], 3, W) for moved in (before, after))
    at_start, at_end = (turn.astype(np.float32) @ side for turn, side in zip((first, second), sides, strict=True))
    out.reshape(at_start.shape)[:] = at_start + at_end + shift.astype(np.float32)[:, None]
    return out
