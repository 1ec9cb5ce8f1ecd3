"""End to end: whole settings of drawing, those of `quality` among them, against a converged picture."""

from __future__ import annotations

from typing import Any

from ...scene.model import Scene
from ...scene.quality import QUALITIES, settings_for
from ..axes import Axis
from ..points import Knobs, grid
from .experiment import Pictures
from .subject import Picture, changed, knows

SAMPLES = 16
"""Of the reference, along each side of a pixel."""
TOLERANCE = 0.05
"""Of its curves, in samples."""


class WholeStudy(Pictures):
    """All knobs of drawing together; time is that of the whole picture."""

    axis = "end to end"

    def choices(self) -> list[Knobs]:
        """The preset's own, the three by name, and a grid about them."""
        out: list[Knobs] = [{"quality": name} for name in ("preset", *QUALITIES)]
        choices: dict[str, Any] = {"image.supersample": (1, 2, 3, 4, 6), "curves.tolerance": (0.25, 1.0, 4.0)}
        if knows(self.scene, "image.resolver"):
            choices = {"image.resolver": ("zbuffer", "sorted"), **choices}
        return out + grid(choices)

    def series(self, knobs: Knobs) -> str:
        """A quality, or a resolver of the grid."""
        if "quality" in knobs:
            return "by name"
        return str(knobs.get("image.resolver", "zbuffer"))

    def reference(self) -> dict[str, Any]:
        """Many samples, fine curves, every strand, and the best shadow map there is."""
        fine: dict[str, Any] = {**settings_for("best", self.scene), "image.supersample": SAMPLES, "detail": None}
        fine |= {"curves.mode": "adaptive", "curves.level": 6, "curves.tolerance": TOLERANCE}
        if knows(self.scene, "image.resolver"):
            thin = self.subject.pixels_wide() * SAMPLES < 1
            clear = getattr(self.scene.material, "opacity", 1.0) < 1
            fine["image.resolver"] = "sorted" if thin or clear else "zbuffer"
        self.fine = self.subject.draw(changed(self.scene, fine), draws=1)
        words = f"{SAMPLES}×{SAMPLES} samples a pixel, curves within {TOLERANCE} samples, the shadow map of best"
        return {"what": words, "mean": float(self.fine.image.mean()), "counts": self.fine.counts}

    def measure(self, knobs: Knobs) -> Any:
        """Draw one setting, a quality as the settings that it stands for."""
        picture = self.subject.draw(self._with(knobs))
        return self.point(knobs, picture, self.errors(knobs, picture))

    def errors(self, knobs: Knobs, picture: Picture) -> dict[str, float | None]:
        """Of the picture."""
        return self.against(picture.image, self.fine.image)

    def _with(self, knobs: Knobs) -> Scene:
        name = knobs.get("quality")
        if name is None:
            return changed(self.scene, knobs)
        return changed(self.scene, {} if name == "preset" else settings_for(name, self.scene))


AXIS = Axis(
    name="end-to-end",
    doc="all settings of drawing together, quality by name among them, against a converged picture",
    knobs=("quality", "image.supersample", "curves.tolerance", "image.resolver"),
    metric="rmse",
    of_preset=True,
    open=WholeStudy,
    pictures=True,
)
