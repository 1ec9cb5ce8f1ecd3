"""The six rules of thesis §2, corrected, for all strands of a scene at once, particle after particle."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from strandcli.scene.motion import emitter_pose, solid_pose

Array = NDArray[np.float64]


class Twin:
    """A scene's strands in float64.

    ``p`` (strands, particles, 3); ``direction`` (strands, 3) is the emitter's direction at each root; ``length``
    (strands, 1) is the rest length of a segment.
    """

    def __init__(self, scene: Any, roots: Array, directions: Array, lengths: Array) -> None:
        self.scene = scene
        self.roots = np.asarray(roots, np.float64)
        self.directions = np.asarray(directions, np.float64)
        n = scene.emitter.particles
        self.length = np.asarray(lengths, np.float64)[:, None] / (n - 1)
        self.p = np.empty((len(self.roots), n, 3))
        self.place(0.0)
        for i in range(1, n):
            self.p[:, i] = self.p[:, i - 1] + self.length * self.direction

    def place(self, time: float) -> None:
        """Set the roots and the directions from the emitter's pose."""
        rotation, translation = (np.array(part) for part in emitter_pose(self.scene.emitter, max(time, 0.0)))
        self.p[:, 0] = self.roots @ rotation.T + translation
        self.direction = self.directions @ rotation.T

    def step(self, time: float, dt: float) -> None:
        """One step of ``dt`` seconds that ends at ``time``."""
        if any(use.name == "emitter_motion" for use in self.scene.rules):
            self.place(time)
        for i in range(1, self.p.shape[1]):
            for use in self.scene.rules:
                if use.name != "emitter_motion":
                    self.p[:, i] = getattr(self, use.name)(i, use.parameters, time, dt)

    def advance(self, frame: int) -> Array:
        """The particles at a frame."""
        time = self.scene.time
        dt = 1 / time.fps / time.substeps
        before = round(time.preroll / dt)
        for j in range(before + (frame - 1) * time.substeps):
            self.step((j + 1 - before) * dt, dt)
        return self.p

    def elasticity(self, i: int, parameters: Any, time: float, dt: float) -> Array:
        d = self.p[:, i] - self.p[:, i - 1]
        size = np.linalg.norm(d, axis=1, keepdims=True)
        share = np.divide(self.length - size, size, out=np.zeros_like(size), where=size > 0)
        return self.p[:, i] + d * share

    def gravity(self, i: int, parameters: Any, time: float, dt: float) -> Array:
        return self.p[:, i] + np.array(parameters.acceleration) * dt**2

    def wind(self, i: int, parameters: Any, time: float, dt: float) -> Array:
        w = self.breeze(parameters, time)
        d = self.p[:, i] - self.p[:, i - 1]
        size = np.linalg.norm(w, axis=1, keepdims=True)
        across = np.linalg.norm(np.cross(w, d), axis=1, keepdims=True)
        caught = np.divide(across, size, out=np.zeros_like(size), where=size > 0)
        return self.p[:, i] + w * dt**2 * caught / (1.0 if parameters.per_length else self.length)

    def breeze(self, parameters: Any, time: float) -> Array:
        """w at each root: three waves from -1 to 1 and back, smoothsteps up and down, of the stated periods."""
        phases = np.random.Generator(np.random.Philox(key=(self.scene.seed, 101))).random(6)
        mean = np.array(parameters.direction) / np.linalg.norm(parameters.direction)
        along = self.p[:, 0] @ mean / parameters.wavelength if parameters.wavelength > 0 else np.zeros(len(self.p))
        gust = gusts(time / parameters.period, along, phases[:3])
        swing = np.radians(parameters.sway) * gusts(time / parameters.period / 1.618, 0 * along, phases[3:])
        x, y, z = mean
        c, s = np.cos(swing), np.sin(swing)
        unit = np.stack([c * x + s * z, y + 0 * c, c * z - s * x], 1)
        return unit * (parameters.strength * (1 - parameters.gust * (1 - gust) / 2))[:, None]

    def stiffness(self, i: int, parameters: Any, time: float, dt: float) -> Array:
        count = self.p.shape[1]
        k = (count - i) * parameters.strength * dt**2
        if parameters.clamp:
            k = min(k, 1.0)
        d1 = self.length * self.direction if i == 1 else self.p[:, i - 1] - self.p[:, i - 2]
        return self.p[:, i] + k * (d1 - (self.p[:, i] - self.p[:, i - 1]))

    def collision(self, i: int, parameters: Any, time: float, dt: float) -> Array:
        p = self.p[:, i]
        chosen = [s for s in self.scene.solids if not parameters.with_ or s.name in parameters.with_]
        for kind in ("sphere", "capsule", "plane", "box"):
            for solid in chosen:
                if solid.kind == kind:
                    p = push_out(p, solid, self.scene.emitter, max(time, 0.0))
        return p


def gusts(turns: float, along: Array, phases: Array) -> Array:
    """Gust factor between -1 and 1."""
    total = np.zeros(len(along))
    for (scale, amplitude), phase in zip(((1.0, 0.55), (0.4142, 0.3), (0.1716, 0.15)), phases, strict=True):
        u = (turns / scale + phase - along / scale) % 1.0
        rise = np.where(u < 0.5, 2 * u, 2 - 2 * u)
        total += amplitude * (2 * (3 * rise**2 - 2 * rise**3) - 1)
    return total


def push_out(p: Array, solid: Any, emitter: Any, time: float) -> Array:
    """Particles (strands, 3), those inside the solid put onto its surface."""
    rotation, centre = (np.array(part) for part in solid_pose(solid, emitter, time))
    local = (p - centre) @ rotation
    if solid.kind == "plane":
        local[:, 1] = np.maximum(local[:, 1], 0)
    elif solid.kind == "box":
        half = np.array(solid.size) / 2
        over = half - np.abs(local)
        inside = (over > 0).all(1)
        face = over.argmin(1)
        rows = np.flatnonzero(inside)
        local[rows, face[rows]] = np.where(local[rows, face[rows]] < 0, -1, 1) * half[face[rows]]
    else:
        core = np.zeros_like(local)
        if solid.kind == "capsule":
            core[:, 1] = np.clip(local[:, 1], -solid.length / 2, solid.length / 2)
        n = local - core
        size = np.linalg.norm(n, axis=1, keepdims=True)
        outside = core + n * solid.radius / np.maximum(size, 1e-300)
        local = np.where(size < solid.radius, outside, local)
    return local @ rotation.T + centre


def depth(p: Array, solid: Any, emitter: Any, time: float) -> Array:
    """How deep points (..., 3) are inside a solid, metres; negative or zero outside."""
    rotation, centre = (np.array(part) for part in solid_pose(solid, emitter, time))
    local = (np.asarray(p, np.float64) - centre) @ rotation
    if solid.kind == "plane":
        return -local[..., 1]
    if solid.kind == "box":
        return (np.array(solid.size) / 2 - np.abs(local)).min(-1)
    if solid.kind == "capsule":
        local = local - np.clip(local[..., 1:2], -solid.length / 2, solid.length / 2) * np.array([0.0, 1.0, 0.0])
    return solid.radius - np.linalg.norm(local, axis=-1)
