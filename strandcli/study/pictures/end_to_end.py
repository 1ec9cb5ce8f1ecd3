"""End to end: whole settings of drawing, those of `quality` among them, against a converged picture."""

from __future__ import annotations

from typing import Any

from ...scene.quality import QUALITIES, settings_for, shadowed
from ..axes import Axis
from ..points import Knobs, grid
from .experiment import Pictures
from .settings import changed
from .subject import Picture

SAMPLES = 16
"""Of the reference, along each side of a pixel."""
TOLERANCE = 0.05
"""Of its curves, in samples."""
LAYERS, TEXELS = 29, 2048
"""Of its opacity maps, and of them texels along a side at most."""


class WholeStudy(Pictures):
    """All knobs of drawing together; time is that of the whole picture."""

    axis = "end to end"

    def choices(self) -> list[Knobs]:
        """The preset's own, the three by name, and a grid about them: samples as each resolver needs them."""
        out: list[Knobs] = [{"quality": name} for name in ("preset", *QUALITIES)]
        for model in ("minmax", "opacity"):
            maps = {f"lights.{i}.shadow.model": model for i in shadowed(self.scene)}
            for resolver, samples in (("zbuffer", (1, 2, 3, 4, 6)), ("sorted", (1, 2, 3))):
                for knobs in grid({"image.supersample": samples, "curves.tolerance": (0.25, 1.0, 4.0)}):
                    out.append({"image.resolver": resolver, **maps, **knobs})
            for knobs in grid({"detail.pixels": (0.125, 0.25, 0.5), "curves.tolerance": (0.25, 1.0)}):
                out.append({"image.resolver": "sorted", **maps, "image.supersample": 1, **knobs})
        return out

    def series(self, knobs: Knobs) -> str:
        """A quality, or a resolver and a model of shadow of the grid."""
        if "quality" in knobs:
            return "by name"
        model = next((value for path, value in knobs.items() if path.endswith("shadow.model")), "no shadow")
        return f"{knobs['image.resolver']}, {model}"

    def reference(self) -> dict[str, Any]:
        """Many samples, fine curves, every strand, and opacity maps of many layers."""
        scene = self.scene
        fine: dict[str, Any] = {"image.supersample": SAMPLES, "detail": None}
        fine |= {"curves.mode": "adaptive", "curves.level": 6, "curves.tolerance": TOLERANCE}
        for i in shadowed(scene):
            fine |= {f"lights.{i}.shadow.model": "opacity", f"lights.{i}.shadow.layers": LAYERS}
            fine |= {f"lights.{i}.shadow.size": TEXELS}
        fine["image.resolver"] = "sorted" if self.subject.needs_sorting(SAMPLES) else "zbuffer"
        self.fine = self.subject.draw(changed(scene, fine), draws=1)
        words = (f"{SAMPLES}×{SAMPLES} samples a pixel, curves within {TOLERANCE} samples, opacity maps of {LAYERS} "
                 "layers")  # fmt: skip
        return {"what": words, "mean": float(self.fine.image.mean()), "counts": self.fine.counts}

    def paths(self, knobs: Knobs) -> Knobs:
        """A quality as the settings that it stands for."""
        name = knobs.get("quality")
        if name is None:
            return knobs
        return {} if name == "preset" else settings_for(name, self.scene)

    def errors(self, knobs: Knobs, picture: Picture) -> dict[str, float | None]:
        """Of the picture."""
        return self.against(picture.image, self.fine.image)


AXIS = Axis(
    name="end-to-end",
    doc="all settings of drawing together, quality by name among them, against a converged picture",
    knobs=("quality", "image.resolver", "shadow.model", "image.supersample", "curves.tolerance", "detail.pixels"),
    metric="rmse",
    of_preset=True,
    open=WholeStudy,
    pictures=True,
)
