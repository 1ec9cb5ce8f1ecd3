"""Runs a batch of cases and measures every strand after every step.

What is measured is the output: the positions that are drawn, in single precision. Rounding them to that costs up to
half a unit in the last place a coordinate, which for short segments far from the origin is more than any threshold:
so much is allowed for, and no more.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...scene.model import Scene, SphereSolid
from ...scene.motion import emitter_pose, solid_pose
from ...simulate import solver_of
from ...simulate.health import RESIDUAL_MOST
from .matrix import Case
from .scenes import groom_of, scene_of, times_of

ROUNDING = float(np.sqrt(3.0) * np.finfo(np.float32).eps)
"""Error of a distance between two points for each metre of their coordinates, half a unit in the last place each."""


@dataclass
class Outcome:
    """What came of one case: each metric's greatest value over all steps; absent where there is none."""

    case: Case
    metrics: dict[str, float] = field(default_factory=dict)
    error: str = ""
    """The exception that ended it, where one did."""


def run(cases: Sequence[Case]) -> list[Outcome]:
    """Outcomes of cases that differ in the start alone."""
    found = [Outcome(case) for case in cases]
    first = cases[0]
    try:
        with np.errstate(all="ignore"):
            times = times_of(first)
            scene, groom = scene_of(first, times), groom_of(cases)
            solver: Any = solver_of(scene)(scene, groom)
            segments = groom.lengths.astype(np.float64) / first.value("n")
            meter = Meter(scene, segments, first.value("L"), touching=first.label("contact") != "none")
            before = solver.particles()
            solver.step(0.0, 0.0)
            moved = {"moved_by_nothing": float(not np.array_equal(before, solver.particles()))}
            meter.follow(solver, times)
    except Exception as error:  # whatever a solver raises is what is looked for here
        for one in found:
            one.error = f"{type(error).__name__}: {error}"
        return found
    for number, one in enumerate(found):
        one.metrics = meter.metrics(slice(number, number + 1) if len(found) > 1 else slice(None)) | moved
    return found


class Meter:
    """Keeps the greatest of every measure, strand by strand."""

    def __init__(self, scene: Scene, segments: NDArray[np.float64], length: float, touching: bool) -> None:
        """``segments`` (strands,) rest lengths of a segment, ``length`` that of a strand, the unit of depths, where
        strands are ``touching`` the scene's spheres; of whole segments where the scene keeps those out."""
        self.segments, self.length, self.scene = segments, length, scene
        self.spheres = [one for one in scene.solids if isinstance(one, SphereSolid) and touching]
        self.overlapping = len(self.spheres) > 1
        self.whole = any(use.name == "collision" and use.parameters.segments for use in scene.rules)
        self.stretch = np.zeros(len(segments))
        self.depth = np.zeros(len(segments))
        self.segment_depth = np.zeros(len(segments))
        self.bad = np.zeros(len(segments), np.int64)
        self.residual: NDArray[np.float64] | None = None
        self.off: NDArray[np.float64] | None = None
        """Of pinned tips from their places."""

    def follow(self, solver: Any, times: NDArray[np.float64]) -> None:
        """Look at a solver's strands after each step, which end at ``times``, seconds from 0."""
        past = 0.0
        pinned = self.scene.solver == "rod" and self.scene.rod.end == "pinned"
        places = self._tips(solver.particles(), 0.0)
        for time in times.tolist():
            solver.step(time, time - past)
            past = time
            particles = solver.particles()
            self.look(particles, past, solver.strand_residuals())
            if pinned:
                off = np.linalg.norm(self._tips(particles, past) - places, axis=1)
                off -= 2 * ROUNDING * np.abs(particles.astype(np.float64)).max()
                self.off = np.maximum(0.0 if self.off is None else self.off, off / self.length)

    def _tips(self, particles: NDArray[np.float32], time: float) -> NDArray[np.float64]:
        """(strands, 3) tips in the emitter's frame."""
        pose = emitter_pose(self.scene.emitter, time)
        return np.asarray((particles[:, -1].astype(np.float64) - pose.translation) @ np.array(pose.rotation))

    def look(self, particles: NDArray[np.float32], time: float, residuals: NDArray[np.floating] | None) -> None:
        """Measure (strands, particles, 3) at a time; ``residuals`` (strands,) are what the solver left."""
        finite: NDArray[np.bool_] = np.asarray(np.isfinite(particles).all((1, 2)))
        self.bad += ~finite
        x = np.where(finite[:, None, None], particles, np.float32(0)).astype(np.float64)
        rounding = ROUNDING * np.abs(x).max((1, 2))
        edges = np.linalg.norm(np.diff(x, axis=1), axis=2)
        off = np.abs(edges - self.segments[:, None]).max(1) - rounding
        self.stretch = np.maximum(self.stretch, np.where(finite, off / self.segments, 0))
        for one in self.spheres:
            centre = np.array(solid_pose(one, self.scene.emitter, time).translation)
            depth = one.radius - np.linalg.norm(x[:, 1:] - centre, axis=2).min(1) - rounding
            self.depth = np.maximum(self.depth, np.where(finite, depth / self.length, 0))
            if self.whole:
                along = _segment_depth(x - centre, one.radius) - rounding
                self.segment_depth = np.maximum(self.segment_depth, np.where(finite, along / self.length, 0))
        if residuals is not None:
            past = np.zeros(len(self.segments)) if self.residual is None else self.residual
            self.residual = np.maximum(past, residuals)  # which keeps NaN

    def metrics(self, strands: slice) -> dict[str, float]:
        """The greatest of some strands."""
        found = {"nonfinite": float(self.bad[strands].sum()), "stretch": float(self.stretch[strands].max())}
        if self.spheres:
            found["overlap" if self.overlapping else "penetration"] = float(self.depth[strands].max())
            if self.whole and not self.overlapping:
                found["segment_penetration"] = float(self.segment_depth[strands].max())
        if self.residual is not None:
            residual = float(self.residual[strands].max())
            found |= {"residual": residual, "stopped": float(not residual <= RESIDUAL_MOST)}
        if self.off is not None:
            found["pinned_off"] = float(self.off[strands].max())
        return found


def _segment_depth(x: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
    """(strands,) greatest depth in a sphere about the origin of the segments between particles (strands, n, 3); of the
    first one, whose root no solver moves, what is deeper than its root."""
    begin, edge = x[:, :-1], np.diff(x, axis=1)
    square = np.maximum((edge**2).sum(-1), np.finfo(np.float64).tiny)
    share = np.clip(-(begin * edge).sum(-1) / square, 0, 1)
    depth = radius - np.linalg.norm(begin + share[..., None] * edge, axis=-1)
    depth[:, 0] -= np.maximum(radius - np.linalg.norm(x[:, 0], axis=-1), 0)
    return np.asarray(depth.max(1))
