"""Michell's ring: a rod that is straight at rest, bent to a closed ring and twisted, leaves its plane (Michell 1889).

It does so at 2 π √3 EI / GJ radians of twist (Zajac 1962). The ring is a strand whose tip is clamped where its root is:
whatever a closed ring does can be moved so that one of its sections stays. The tip is turned slowly. Of two rings one
is bent a little; while they are stable they come nearer to each other, and from the twist that is sought on they part.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...groom.record import Groom
from .base import Case, Reference, Track, off, preset

TORSION = 0.75
"""GJ over EI."""
RANGE = (0.85, 1.1)
"""The tip's turn over that of the onset, from when it has been turned so far to the end."""
BEGUN, SPAN = 2.0, 12.0
"""Seconds at which that begins and ends."""
BEND = 1e-3
"""How far the second ring is bent out of its plane, in radii."""
NEAR = 0.04
"""Of the onset: about the closest moment, what a parabola is laid through."""


def turns() -> float:
    """Turns at the onset."""
    return math.sqrt(3) / TORSION


def exact() -> dict[str, float]:
    """Radians at the onset."""
    return {"θ": 2 * math.pi * turns()}


def ring(n: int, bend: float) -> NDArray[np.float64]:
    """(n, 3) unit edges of a ring in the plane z = 0, from the origin along x; its middle is bent."""
    angle = 2 * math.pi * np.arange(n + 1) / n
    wave = 2 * math.pi * np.clip((np.arange(n + 1) / n - 0.15) / 0.7, 0, 1)  # both ends are as they were
    corners = np.stack([np.sin(angle), 1 - np.cos(angle), bend * np.sin(wave) ** 3], 1)
    edges = np.diff(corners, axis=0)
    return np.asarray(edges / np.linalg.norm(edges, axis=1, keepdims=True))


def case(particles: int) -> Case:
    """Two rings, that differ a little."""
    n = particles - 1
    made = Groom(
        np.zeros((2, 3), np.float32), np.array([[1, 0, 0]] * 2, np.float32), np.ones(2, np.float32),
        np.zeros(2, np.float32), ways=np.stack([ring(n, 0.0), ring(n, BEND)]),
    )  # fmt: skip
    settings = preset(0.01, 2, particles, gravity=0.0, drag=20.0)
    # the last edge is half a joint's angle short of the root's direction
    closed = {"rotation": (0.0, 0.0, 180 / n), "ease": "linear"}
    low, high = RANGE
    settings["rod"] |= {
        "end": "clamped",
        "torsion": TORSION,
        "precision": "double",
        "end_keys": [
            {"time": 0.0, **closed},
            {"time": BEGUN, "turns": low * turns(), **closed},
            {"time": SPAN, "turns": high * turns(), **closed},
        ],
    }
    return Case(settings, made)


def apart(positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T,) root mean square of how far two rings are apart, of (T, 2, particles, 3), each turned about the tangent at
    its ends, about which it turns freely, until its middle is over the same line."""
    strands = positions - positions[:, :, :1]
    y, z = strands[..., 1], strands[..., 2]
    angle = np.arctan2(z.sum(2), y.sum(2))[..., None]
    turned = np.stack([strands[..., 0], y * np.cos(angle) + z * np.sin(angle), z * np.cos(angle) - y * np.sin(angle)])
    return np.asarray(np.sqrt(((turned[:, :, 1] - turned[:, :, 0]) ** 2).mean((0, 2))))


def measure(track: Track) -> dict[str, float | None]:
    """``onset``: relative error of the twist from which on rings part; None where they do not, or always do."""
    low, high = RANGE
    late = track.times >= BEGUN
    twist = low + (high - low) * (track.times[late] - BEGUN) / (SPAN - BEGUN)
    size = np.log(np.maximum(apart(track.positions[late]), 1e-30))
    least = int(np.argmin(size))
    if least in (0, len(size) - 1):
        return {"onset": None}
    near = abs(twist - twist[least]) < NEAR
    a, b, _ = np.polyfit(twist[near] - 1, size[near], 2)
    return {"onset": off(1 - b / (2 * a), 1.0) if a > 0 else None}


REFERENCE = Reference(
    name="michell",
    title="Michell's instability of a twisted ring, 2 π √3 EI / GJ",
    metric="onset",
    unit="of the twist",
    needs=("bending", "two ends", "twist", "turned end"),
    span=SPAN,
    exact=exact,
    case=case,
    measure=measure,
    moving=True,
    steps={"rod": (1 / 24, 1 / 60)},
    particles=(17, 25, 37),
)
