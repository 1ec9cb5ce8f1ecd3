"""Ambient occlusion: a grid against rays that meet strands as cylinders, and solids, in many directions.

What is compared is the share of an even sky that reaches the points of strands that the picture shows.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import solids as shapes
from ...draw.common.scratch import Scratch
from ...draw.geometry.curves import Polylines, flatten
from ...draw.geometry.extent import Thickness
from ...draw.lighting import occlusion
from ...draw.solids.kernels import rays
from ...errors import UsageError
from ...scene.model import AmbientOcclusion, DirectionalLight
from ..axes import changed
from ..points import Parameters
from .experiment import Pictures
from .shadow import bundle, transmittance
from .subject import Picture

PROBES = 300
SKY = 96
"""Directions of the reference."""
RAYS = 6
"""Of each direction, over a disc as wide as the distance between strands."""
CELLS = (8_000, 25_000, 50_000, 100_000, 200_000, 400_000)
DIRECTIONS = (8, 16, 64, 128)


class OcclusionStudy(Pictures):
    """Cells and directions of the grid."""

    axis = "occlusion"
    metric, unit, stages = "share", "of the sky", ("shadow", "shade")

    def choices(self) -> list[Parameters]:
        """None at all, cells, and directions with the usual cells."""
        usual = AmbientOcclusion()
        grids = [(cells, usual.directions) for cells in CELLS] + [(usual.cells, count) for count in DIRECTIONS]
        return [{"ambient_occlusion": None}] + [
            {"ambient_occlusion.cells": cells, "ambient_occlusion.directions": count} for cells, count in grids
        ]

    def series(self, parameters: Parameters) -> str:
        """By which of the two parameters is turned."""
        if "ambient_occlusion" in parameters:
            return "none"
        usual = parameters["ambient_occlusion.directions"] == AmbientOcclusion().directions
        return "cells" if usual else "directions"

    def reference(self) -> dict[str, Any]:
        """Rays from points of strands that are seen."""
        rng = np.random.default_rng(0)
        subject, scene = self.subject, self.scene
        seen = subject.draw(scene, draws=1, keep_shading=True).vertices()
        if not len(seen.light):
            raise UsageError(f"{subject.name}: no strand is seen, and so no occlusion to be studied")
        chosen = rng.permutation(len(seen.light))[:PROBES]
        self.points = seen.places[chosen]
        lines = flatten(*subject.whole(), subject.groom.strands, scene.curves, subject.view(scene), True, Scratch())
        thickness = Thickness(scene.material.width, scene.material.drawn_taper)
        spacing = subject.spacing()
        halves = seen_of_sky(
            lines, thickness, self._packed(), self.points, seen.strands[chosen],
            bundle(RAYS, spacing, rng), 0.01 * scene.emitter.length,
        )  # fmt: skip
        self.truth = halves.mean(1)
        noise = float(np.abs(halves[:, 0] - halves[:, 1]).mean() / 2)
        return {"what": f"{RAYS} rays in each of {SKY} directions from {len(chosen)} points that are seen, "
                        "against cylinders and solids",
                "mean": float(self.truth.mean()), "noise": noise, "spacing": spacing}  # fmt: skip

    def measure(self, parameters: Parameters) -> Any:
        """Timed without lamps."""
        even = {"lights": (), "ambient": (1.0, 1.0, 1.0), "environment": None}
        picture = self.subject.draw(changed(self.scene, {**even, **parameters}))
        return self.point(parameters, picture, self.errors(parameters, picture))

    def errors(self, parameters: Parameters, picture: Picture) -> dict[str, float | None]:
        """Mean of the absolute difference of the share that is seen, signed mean, 95th percentile."""
        settings = changed(self.scene, parameters).ambient_occlusion
        found = np.ones(len(self.truth))
        if settings is not None:
            scene, subject = self.scene, self.subject
            made = occlusion.build(
                settings, subject.whole()[0], subject.groom.strands, subject.bounds(),
                Thickness(scene.material.width, scene.material.drawn_taper), None, self._packed(), Scratch(),
            )  # fmt: skip
            found = made.at(self.points)
        off = found - self.truth
        return {"share": float(np.abs(off).mean()), "bias": float(off.mean()),
                "p95": float(np.percentile(np.abs(off), 95))}  # fmt: skip

    def _packed(self) -> shapes.Solids | None:
        visible = [solid for solid in self.scene.solids if solid.visible]
        if not visible:
            return None
        return shapes.pack_all(visible, self.scene.emitter, self.subject.at)


def seen_of_sky(
    lines: Polylines, thickness: Thickness, packed: shapes.Solids | None, points: NDArray[np.float64],
    own: NDArray[np.int64], jitter: NDArray[np.float64], skin: float, sky: int = SKY,
) -> NDArray[np.float64]:  # fmt: skip
    """(P, 2): the share of an even sky that polylines as cylinders and solids leave points (P, 3) on the strands
    ``own`` (P,), by the even and the odd rays of bundles ``jitter`` (R, 2) metres wide in each direction."""
    found = np.zeros((len(points), 2))
    for direction in occlusion.directions(sky).astype(np.float64):
        left = transmittance(lines, thickness, DirectionalLight(direction=tuple(-direction)), points, own, jitter)
        if packed is not None:
            to, far = direction.astype(np.float32), np.float32(1e30)
            for p, point in enumerate(points.astype(np.float32)):
                left[p] *= rays.visibility(packed, *point, *to, far, np.float32(skin))
        found += left / sky
    return found
