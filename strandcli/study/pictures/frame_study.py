"""Settings of drawing against a converged picture, in windows of a preset's whole frame: what `render --max-error
picture=ERROR` chooses by."""

from __future__ import annotations

import time
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import RefusedError
from ...output.flip import mean_flip
from ...plan import checked_plan
from ...scene.look import LOOKS
from ...scene.quality import settings_for, shadowed
from ..axes import Request
from ..points import Knobs, Point
from .end_to_end import LAYERS, SAMPLES, TEXELS, TOLERANCE, WholeStudy
from .settings import changed
from .subject import Picture
from .windows import Windows

PATIENCE = 40.0
"""Seconds for the reference and all settings; those that are left then are not tried."""
ALWAYS = 2
"""Settings that are tried in any case: the finest and the preset's own."""
FINEST = 6
"""Level of curves where a tolerance decides."""
STUDIED, CHECKED = 2 / 3, 1 / 3
"""Which windows are taken (see `spread`) by the study, and after it to check a frame that was drawn: never the same
where there are more than a few."""


class FrameStudy(WholeStudy):
    """Knobs of drawing that a preset's picture may be had cheaper or finer by, strands and their number untouched."""

    axis = "frame"
    phase = STUDIED

    def open_subject(self, request: Request) -> Windows:
        """All strands of the frame, in windows of its picture."""
        return Windows(request, self.phase)

    @property
    def windows(self) -> Windows:
        """The subject."""
        assert isinstance(self.subject, Windows)
        return self.subject

    def choices(self) -> list[Knobs]:
        """The finest, so that what can be reached is known however long the others take; the preset's own settings, the
        qualities, and samples and tolerances between them."""
        draft, default, best = (settings_for(name, self.scene) for name in ("draft", "default", "best"))
        fine: dict[str, Any] = {"image.resolver": "sorted", "curves.mode": "adaptive", "curves.level": FINEST}
        fine |= {f"lights.{i}.shadow.model": "opacity" for i in shadowed(self.scene)}

        def made(samples: int, tolerance: float) -> dict[str, Any]:
            return {**fine, "image.supersample": samples, "curves.tolerance": tolerance}

        finest = {**self.converged(), "image.supersample": SAMPLES // 2}
        found: list[Knobs] = [finest, {}, made(4, 0.05), made(2, 0.05), best, default, made(1, 0.05), made(6, 0.05)]
        found += [made(3, 0.05), made(2, 0.25)]
        found += [draft, made(1, 0.25), {**made(1, 1.0), "detail.pixels": 0.25}, {**made(1, 1.0), "detail.pixels": 0.5}]
        if self.scene.image.resolver == "zbuffer":
            found += [{"image.supersample": samples} for samples in (2, 3, 4, 6, 8)]
        return found

    def _fitting(self, knobs: Knobs) -> Knobs | None:
        """A choice with the highest level of curves that the whole frame has memory for; None where it has none."""
        assert self.request.scene is not None
        for level in (None, 5, 4, 3, 2):
            made = dict(knobs)
            if level is not None:
                if not knobs.get("curves.level", 0) > level:
                    continue
                made["curves.level"] = level
            with suppress(RefusedError):
                checked_plan(changed(self.request.scene, made), (self.subject.frame,))
                return made
        return None

    def converged(self) -> dict[str, Any]:
        """The settings of the reference: those of the axis end to end, but always sorted, which converges sooner, and
        with no fewer layers than the preset has."""
        fine: dict[str, Any] = {"image.resolver": "sorted", "image.supersample": SAMPLES, "detail": None}
        fine |= {"curves.mode": "adaptive", "curves.level": FINEST, "curves.tolerance": TOLERANCE}
        for i in shadowed(self.scene):
            layers = max(LAYERS, self.scene.lights[i].shadow.layers)
            fine |= {f"lights.{i}.shadow.model": "opacity", f"lights.{i}.shadow.layers": layers}
            fine[f"lights.{i}.shadow.size"] = TEXELS
        return fine

    def settings(self) -> list[Knobs]:
        """The choices that are left by what was set by hand, by the look and by the memory that is free."""
        looks, drawn = LOOKS.get(self.scene.look, ()), []
        allowed = {one.path.replace("*", str(i)): one.values for one in looks for i in range(len(self.scene.lights))}
        found = []
        for chosen in super().settings():
            knobs = self._fitting(chosen)
            if knobs is None:
                continue
            scene = changed(self.scene, knobs)
            if scene not in drawn and all(value in allowed.get(path, (value,)) for path, value in knobs.items()):
                drawn.append(scene)
                found.append(knobs)
        return found

    def reference(self) -> dict[str, Any]:
        """Draw the reference, and learn what a whole frame takes."""
        self._began, self._measured = time.monotonic(), 0
        self.draw_reference()
        what = (
            f"{SAMPLES}×{SAMPLES} samples a pixel, curves within {TOLERANCE} samples, opacity maps of {LAYERS} layers"
        )
        return {
            "what": what, "mean": self.windows.mean, "counts": self.fine.counts,
            "windows": [list(window) for window in self.windows.windows], "own_seconds": self.windows.calibrate(),
            "width": self.width_given(),
        }  # fmt: skip

    def draw_reference(self) -> None:
        """Draw what errors are measured against; strands have to be moved."""
        self.fine = self.windows.draw(changed(self.scene, self.converged()))

    def paths(self, knobs: Knobs) -> Knobs:
        """Choices are settings already."""
        return knobs

    def width_given(self) -> dict[str, float]:
        """The settings that give lines of no width the width of the reference; nothing for other strands."""
        if not self.subject.widened:
            return {}
        return {"material.width": self.scene.material.width, "material.taper": self.scene.material.drawn_taper}

    def measure(self, knobs: Knobs) -> Point:
        """Draw one setting; after `PATIENCE` none but the first two, and the point has no error."""
        self._measured += 1
        if self._measured > ALWAYS and time.monotonic() - self._began > PATIENCE:
            return Point(knobs=knobs, seconds=0.0, error={"rmse": None, "flip": None}, series=self.series(knobs))
        return super().measure(knobs)

    def series(self, knobs: Knobs) -> str:
        """The resolver."""
        return str(knobs.get("image.resolver", self.scene.image.resolver))

    def errors(self, knobs: Knobs, picture: Picture) -> dict[str, float | None]:
        """Of the picture: root mean square in linear light, and ꟻLIP."""
        assert picture.pixels is not None
        return {"rmse": self.rmse(picture.image), "flip": self.flip(picture.pixels)}

    def rmse(self, image: NDArray[np.float64]) -> float | None:
        """Root mean square difference of the windows' light, one below the other, from the reference's, a share of the
        mean light of all of the frame that has strands."""
        off = float(np.sqrt(((image - self.fine.image) ** 2).mean()))
        return off / self.windows.mean if self.windows.mean > 0 else None

    def flip(self, pixels: NDArray[np.uint8]) -> float:
        """Mean ꟻLIP of the windows' pixels, one below the other, against the reference's."""
        assert self.fine.pixels is not None
        pairs = zip(self.windows.apart(self.fine.pixels), self.windows.apart(pixels), strict=True)
        return float(np.mean([mean_flip(one, other) for one, other in pairs]))
