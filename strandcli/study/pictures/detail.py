"""Level of detail: fewer and wider strands against all of them, near and far, by shares and by width on the screen."""

from __future__ import annotations

from typing import Any

from ...scene.model import Scene
from ..points import Knobs
from ..settings import changed, silhouette
from .experiment import Pictures
from .subject import Picture, differences

SAMPLES = 8
"""Of the reference, along each side of a pixel."""
FARTHER = (1, 4, 16)
"""How many times farther away the groom is looked at: with so many times fewer pixels along each side."""
AT_ONCE = 1e-6
"""Metres: `detail.near` so close that the fraction alone decides."""


class DetailStudy(Pictures):
    """Fraction and widening of `detail`."""

    axis = "level of detail"
    references = 1

    def choices(self) -> list[Knobs]:
        """Fractions with and without widening; as many as are wide enough on the screen."""
        out: list[Knobs] = [{"detail.near": AT_ONCE, "detail.fraction": 1.0, "detail.widen": True}]
        for part in (2, 4, 8, 16, 32):
            for widen in (True, False):
                out.append({"detail.near": AT_ONCE, "detail.fraction": 1 / part, "detail.widen": widen})
        for pixels in (0.25, 0.5, 1.0, 2.0):
            by_width = {"detail.near": None, "detail.pixels": pixels, "detail.fraction": 0.01, "detail.widen": True}
            out.append(by_width)
        return out

    def series(self, knobs: Knobs) -> str:
        """What decides on the share, and whether strands are widened."""
        if knobs["detail.near"] is None:
            return "by width"
        return "widened" if knobs["detail.widen"] else "not widened"

    def reference(self) -> dict[str, Any]:
        """All strands with many samples a pixel, at every distance."""
        self.pictures, self.covered = {}, {}
        for times in FARTHER:
            scene = changed(self._farther(times), {"image.supersample": SAMPLES, "detail": None})
            self.pictures[times] = self.subject.draw(scene, draws=1)
            self.covered[times] = self.subject.draw(silhouette(scene), draws=1)
        return {"what": f"all strands, {SAMPLES}×{SAMPLES} samples a pixel",
                "mean": float(self.pictures[1].image.mean()), "counts": self.pictures[1].counts}  # fmt: skip

    def errors(self, knobs: Knobs, picture: Picture) -> dict[str, float | None]:
        """Of the picture and of the area of white strands before black, at every distance."""
        error: dict[str, float | None] = {}
        for times in FARTHER:
            scene = changed(self._farther(times), knobs)
            one = picture if times == 1 else self.subject.draw(scene, draws=1)
            white = self.subject.draw(silhouette(scene), draws=1)
            seen = differences(one.image, self.pictures[times].image)
            ending = "" if times == 1 else f" ×{times}"
            error[f"rmse{ending}"] = seen["rmse"]
            error[f"area{ending}"] = differences(white.image, self.covered[times].image)["bias"]
            if times == 1:
                error |= {"bias": seen["bias"], "p99": seen["p99"]}
        return error

    def _farther(self, times: int) -> Scene:
        width, height = self.scene.image.size
        return changed(self.scene, {"image.size": (max(1, width // times), max(1, height // times))})
