"""Curves: straight pieces against a far finer level, on the screen and in the picture."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...draw.common.scratch import Scratch
from ...draw.geometry.curves import flatten
from ...draw.view.camera import View
from ...scene.model import Scene
from ..points import Knobs
from ..settings import changed
from .experiment import Pictures
from .subject import Picture, differences

LEVEL = 8
"""Of the reference: 256 pieces a segment."""
TRACED = 64
"""Strands whose distances are measured, the first ones."""
PLACES = 23
"""Points a segment at which they are: not where any level has its own."""


class CurveStudy(Pictures):
    """Modes, levels and tolerances of `curves`."""

    axis, stages = "curves", ("curves", "raster")

    def choices(self) -> list[Knobs]:
        """Straight, evenly cut, and cut by a tolerance; the level of the last is but its limit."""
        out: list[Knobs] = [{"curves.mode": "off"}]
        out += [{"curves.mode": "fixed", "curves.level": level} for level in range(1, 6)]
        for tolerance in (4.0, 2.0, 1.0, 0.5, 0.25, 0.1, 0.05):
            out.append({"curves.mode": "adaptive", "curves.level": 6, "curves.tolerance": tolerance})
        return out

    def series(self, knobs: Knobs) -> str:
        """The mode."""
        return str(knobs["curves.mode"])

    def reference(self) -> dict[str, Any]:
        """The picture of the finest level, and the curves themselves in double precision."""
        finest = changed(self.scene, {"curves.mode": "fixed", "curves.level": LEVEL})
        self.finest = self.subject.draw(finest, draws=1)
        # the source's printed tangents make other curves: there distances are not told
        self.traced: NDArray[np.float64] | None = None
        if self.scene.curves.tangents == "difference" and self.scene.emitter.tie is None:  # tied ones are uneven
            lengths = self.subject.lengths.reshape(-1)[: self.subject.groom.strands].astype(np.float64)
            self.traced = bezier(self.subject.points()[:TRACED], lengths[:TRACED], PLACES)
        return {"what": f"level {LEVEL}, and curves in double precision", "mean": float(self.finest.image.mean()),
                "counts": self.finest.counts}  # fmt: skip

    def errors(self, knobs: Knobs, picture: Picture) -> dict[str, float | None]:
        """Of the picture, and distances on the screen in pixels of the picture."""
        error = differences(picture.image, self.finest.image)
        scene = changed(self.scene, knobs)
        apart = self._distances(scene) if self.traced is not None else None
        known = apart is not None and len(apart) > 0
        error["distance px"] = float(np.mean(apart)) if known and apart is not None else None
        error["farthest px"] = float(np.max(apart)) if known and apart is not None else None
        return error

    def _distances(self, scene: Scene) -> NDArray[np.float64]:
        """(points seen,) pixels from the true curves' points to the polylines drawn."""
        assert self.traced is not None
        view, strands = self.subject.view(scene), len(self.traced)
        fine = scene.image.supersample
        sampled = changed(scene, {"image.size": (scene.image.size[0] * fine, scene.image.size[1] * fine)})
        lines = flatten(
            self.subject.positions, self.subject.lengths, strands, scene.curves, self.subject.view(sampled), True,
            Scratch(),
        )  # fmt: skip
        truth, seen = on_screen(self.traced, view)
        found = []
        for s in range(strands):
            drawn, whole = on_screen(lines.world[lines.first[s] : lines.first[s + 1]].astype(np.float64), view)
            if whole.all() and seen[s].any():
                found.append(to_polyline(truth[s][seen[s]], drawn))
        return np.concatenate(found) if found else np.empty(0)


def bezier(points: NDArray[np.float64], lengths: NDArray[np.float64], places: int) -> NDArray[np.float64]:
    """Points on the smooth curves through particles, ``places`` a segment and the tip (strands, m, 3).

    points (strands, n + 1, 3): the row before the root, then n particles; lengths (strands,) of a segment at rest. Each
    segment is the cubic Bézier curve whose inner control points lie a third of that length along the unit tangents at
    its ends: central differences, the strand's direction at the root, none at the tip.
    """
    p = points[:, 1:]
    way = np.zeros_like(p)
    way[:, 0] = points[:, 1] - points[:, 0]
    way[:, 1:-1] = p[:, 2:] - p[:, :-2]
    size = np.linalg.norm(way, axis=2, keepdims=True)
    reach = np.divide(way, size, out=np.zeros_like(way), where=size > 0) * (lengths / 3)[:, None, None]
    t = (np.arange(places) / places)[:, None]
    a, d = p[:, :-1, None], p[:, 1:, None]
    b, c = a + reach[:, :-1, None], d - reach[:, 1:, None]
    curve = (1 - t) ** 3 * a + 3 * t * (1 - t) ** 2 * b + 3 * t**2 * (1 - t) * c + t**3 * d
    return np.concatenate([curve.reshape(len(p), -1, 3), p[:, -1:]], 1)


def on_screen(points: NDArray[np.float64], view: View) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Points (..., 3) in pixels (..., 2), and which of them the picture shows."""
    away = points - view.eye
    depth = away @ view.forward
    away_from = np.where(depth > view.near, depth, 1.0) if view.perspective else np.ones_like(depth)
    scale = view.focal / away_from
    x = view.width / 2 + scale * (away @ view.right)
    y = view.height / 2 - scale * (away @ view.up)
    inside = (depth > view.near) & (x >= 0) & (y >= 0) & (x < view.width) & (y < view.height)
    return np.stack([x, y], -1), inside


def to_polyline(points: NDArray[np.float64], line: NDArray[np.float64]) -> NDArray[np.float64]:
    """(m,) distances of points (m, 2) from the nearest piece of a polyline (k, 2)."""
    begin, way = line[:-1], np.diff(line, axis=0)
    square = np.maximum((way**2).sum(1), 1e-300)
    t = np.clip(((points[:, None] - begin) * way).sum(2) / square, 0, 1)
    return np.asarray(np.linalg.norm(points[:, None] - begin - t[..., None] * way, axis=2).min(1))
