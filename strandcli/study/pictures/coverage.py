"""Coverage: samples a pixel, and what decides who is seen, against 16×16 samples; occupancy maps as a foil."""

from __future__ import annotations

from typing import Any

from ..axes import Axis
from ..points import Knobs, Point
from .experiment import Pictures
from .occupancy import SLABS, SLICES, OccupancyRenderer
from .subject import Picture, changed, silhouette

SAMPLES = 16
"""Of the reference, along each side of a pixel."""


class CoverageStudy(Pictures):
    """Samples and resolvers of `image`."""

    axis, stages = "coverage", ("raster", "shade", "film")

    def choices(self) -> list[Knobs]:
        """Every resolver with its own useful range of samples."""
        out: list[Knobs] = [{"image.resolver": "zbuffer", "image.supersample": n} for n in (1, 2, 3, 4, 6, 8)]
        out += [{"image.resolver": "sorted", "image.supersample": n} for n in (1, 2, 3, 4)]
        out += [{"image.resolver": "kbuffer", "image.nearest": k, "image.supersample": 1} for k in (2, 4, 8, 16)]
        return out

    def settings(self) -> list[Knobs]:
        """Those, and the foil, where neither resolver nor samples are set by hand."""
        if self.request.fixed & {"image.resolver", "image.supersample"}:
            return super().settings()
        return super().settings() + [{"foil": "occupancy", "slices": n, "slabs": SLABS} for n in (32, SLICES, 512)]

    def measure(self, knobs: Knobs) -> Point:
        """One setting; the foil takes the time of `sorted`, less that of sorting, and its own."""
        if "foil" not in knobs:
            return super().measure(knobs)
        scene = changed(self.scene, {"image.resolver": "sorted"})
        exact = self.subject.draw(scene)
        renderer = OccupancyRenderer(scene, self.subject.groom)
        renderer.take_over(knobs["slices"], knobs["slabs"])
        picture = self.subject.draw(scene, renderer=renderer)
        sorting, occupancy = renderer.seconds
        error = self.against(picture.image, self.fine.image)
        error["from sorted"] = self.against(picture.image, exact.image)["rmse"]
        point = self.point(knobs, exact, error)
        point.seconds += occupancy - sorting
        point.counts = {**exact.counts, "sorting_us": round(1e6 * sorting), "occupancy_us": round(1e6 * occupancy)}
        return point

    def series(self, knobs: Knobs) -> str:
        """The resolver."""
        return str(knobs.get("foil", knobs.get("image.resolver", "zbuffer")))

    def reference(self) -> dict[str, Any]:
        """Opaque strands need no more than who is in front; others are sorted."""
        resolver = "sorted" if self.subject.needs_sorting(SAMPLES) else "zbuffer"
        scene = changed(self.scene, {"image.supersample": SAMPLES, "image.resolver": resolver})
        self.fine = self.subject.draw(scene, draws=1)
        self.covered = self.subject.draw(silhouette(scene), draws=1)
        return {"what": f"{SAMPLES}×{SAMPLES} samples a pixel", "mean": float(self.fine.image.mean()),
                "counts": self.fine.counts, "covered": float(self.covered.image.mean())}  # fmt: skip

    def errors(self, knobs: Knobs, picture: Picture) -> dict[str, float | None]:
        """Of the picture; and of white strands before black their whole area, signed, and the root mean square of a
        pixel's share that they cover."""
        error = self.against(picture.image, self.fine.image)
        white = self.subject.draw(silhouette(changed(self.scene, knobs)), draws=1)
        shape = self.against(white.image, self.covered.image)
        error["area"] = shape["bias"]
        off = white.image - self.covered.image
        error["cover"] = float((off**2).mean() ** 0.5)
        return error


AXIS = Axis(
    name="coverage",
    doc="samples and resolvers against 16×16 samples a pixel",
    knobs=("image.resolver", "image.supersample", "image.nearest"),
    metric="rmse",
    of_preset=True,
    open=CoverageStudy,
    pictures=True,
)
