"""Coverage: samples a pixel, and what decides who is seen, against 16×16 samples."""

from __future__ import annotations

from typing import Any

from ..points import Parameters
from ..settings import changed, silhouette
from .experiment import Pictures
from .subject import Picture, differences

SAMPLES = 16
"""Of the reference, along each side of a pixel."""


class CoverageStudy(Pictures):
    """Samples and resolvers of `image`."""

    axis, stages = "coverage", ("raster", "shade", "film")

    def choices(self) -> list[Parameters]:
        """Every resolver with its own useful range of samples."""
        out: list[Parameters] = [{"image.resolver": "zbuffer", "image.supersample": n} for n in (1, 2, 3, 4, 6, 8)]
        out += [{"image.resolver": "sorted", "image.supersample": n} for n in (1, 2, 3, 4)]
        return out

    def series(self, parameters: Parameters) -> str:
        """The resolver."""
        return str(parameters.get("image.resolver", "zbuffer"))

    def reference(self) -> dict[str, Any]:
        """Opaque strands need no more than who is in front; others are sorted."""
        resolver = "sorted" if self.subject.needs_sorting(SAMPLES) else "zbuffer"
        scene = changed(self.scene, {"image.supersample": SAMPLES, "image.resolver": resolver})
        self.fine = self.subject.draw(scene, draws=1)
        self.covered = self.subject.draw(silhouette(scene), draws=1)
        return {"what": f"{SAMPLES}×{SAMPLES} samples a pixel", "mean": float(self.fine.image.mean()),
                "counts": self.fine.counts, "covered": float(self.covered.image.mean())}  # fmt: skip

    def errors(self, parameters: Parameters, picture: Picture) -> dict[str, float | None]:
        """Of the picture; and of white strands before black their whole area, signed, and the root mean square of a
        pixel's share that they cover."""
        error = differences(picture.image, self.fine.image)
        white = self.subject.draw(silhouette(changed(self.scene, parameters)), draws=1)
        shape = differences(white.image, self.covered.image)
        error["area"] = shape["bias"]
        off = white.image - self.covered.image
        error["cover"] = float((off**2).mean() ** 0.5)
        return error
