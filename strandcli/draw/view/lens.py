"""Depth of field and motion blur: which views and moments a picture is averaged over.

A picture is the mean of whole pictures, each through one point of a thin lens at one moment (the accumulation buffer of
Haeberli and Akeley 1990): exact in visibility, shading and shadow, and any resolver's. Points and moments follow an
additive recurrence that begins at random: each is spread evenly by itself and against the others (Roberts 2018, as for
roots), the mean has no bias, and the seed alone decides it. What goes into a z-buffer is moved by a part of a sample
besides, another one each time, so that what is sharp is antialiased too.
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
from .kernels import shutter


class Exposure(NamedTuple):
    """One of the pictures that are averaged."""

    at: float
    """Moment, seconds."""
    share: float
    """Of the way from the frame before (0) to the frame itself (1)."""
    right: float = 0.0
    up: float = 0.0
    """Point of the lens, metres from its middle."""
    x: float = 0.0
    y: float = 0.0
    """Part of a sample that the picture is moved by, from −1/2 to 1/2."""


def is_sampled(camera: Camera) -> bool:
    """Whether a picture takes more than one exposure at all."""
    return camera.aperture > 0 or camera.shutter > 0


def exposures(camera: Camera, seed: int, at: float, fps: float) -> list[Exposure]:
    """The exposures of the frame at a time; one through a pinhole where neither lens nor shutter is open.

    The shutter is open from ``at`` − shutter / fps to ``at``, and everything stands still before time 0. Every frame
    has the same points of the lens, so that what stands still does not flicker.
    """
    if not is_sampled(camera):
        return [Exposure(at, 1.0)]
    count = camera.samples
    start = stream(seed, 6, 5)
    index = np.arange(count)
    across = concentric((start[0] + index / PLASTIC) % 1.0, (start[1] + index / PLASTIC**2) % 1.0)
    offsets = camera.aperture / 2 * across
    ago = camera.shutter * (1.0 - (index + start[2]) / count)
    # irrational steps whose sums with places of the lens, too, are spread evenly: many others, √2 and √5 say, are not
    aside = (start[3:, None] + index * np.sqrt([[13.0], [22.0]])) % 1.0 - 0.5
    return [
        Exposure(max(at - float(late) / fps, 0.0), 1.0 - float(late), float(right), float(up), float(x), float(y))
        for late, (right, up), (x, y) in zip(ago, offsets, aside.T, strict=True)
    ]


def concentric(u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 2) points of the unit disc from points of the unit square, areas kept and neighbours left neighbours
    (Shirley and Chiu 1997)."""
    a, b = 2 * u - 1, 2 * v - 1
    wide = np.abs(a) > np.abs(b)
    radius = np.where(wide, a, b)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(wide, b / a, np.where(b == 0, 0.0, a / b))
    angle = np.where(wide, np.pi / 4 * ratio, np.pi / 2 - np.pi / 4 * ratio)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], 1)


def focus_of(camera: Camera, at: float) -> float:
    """The depth that is sharp, metres."""
    if camera.focus is not None:
        return camera.focus
    view = camera_at(camera, at)
    return math.dist(view.position, view.target)


def through_lens(view: View, camera: Camera, exposure: Exposure) -> View:
    """A pinhole's view from an exposure's point of the lens."""
    if camera.aperture == 0:
        return view
    return view.through(exposure.right, exposure.up, focus_of(camera, exposure.at))


def between(
    before: NDArray[np.float32], after: NDArray[np.float32], emitter: Emitter, carried: bool,
    start: float, end: float, exposure: Exposure, out: NDArray[np.float32],
) -> NDArray[np.float32]:  # fmt: skip
    """Strands (blocks, rows, 3 W) at an exposure's moment, from those at ``start`` and ``end``, seconds; into ``out``.

    Linear in the emitter's frame where it carries the strands, else in the world. So what moves rigidly with the
    emitter is exact, roots above all; anything else is off by at most |a| (end − start)² / 8, a being its acceleration
    in that frame.
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
    numbers = np.concatenate([first.ravel(), second.ravel(), shift]).astype(np.float32)
    shutter.blend(before, after, numbers, W, out)
    return out
