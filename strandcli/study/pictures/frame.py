"""Settings of drawing against a converged picture, in windows of a preset's whole frame: what `render --max-error
picture=ERROR` chooses by, what samples and resolvers cost, and where `quality: draft, default, best` stand beside the
front of settings.

All strands are there and pixels are those of the picture: strands that are a fifth of a pixel wide and crowded have
errors several times those of the first 2,000 in a small picture.
"""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from ...errors import RefusedError, UsageError
from ...output.flip import mean_flip
from ...plan import checked_plan
from ...scene.fields import value_at
from ...scene.model import Scene
from ...scene.quality import LOOKS, QUALITIES, settings_for, shadowed
from ..points import Parameters, Point, grid
from ..sweep import Experiment, Request, changed, knows
from .subject import Picture, Subject
from .windows import Windows

SAMPLES = 16
"""Of the reference, along each side of a pixel."""
TOLERANCE = 0.05
"""Of its curves, in samples."""
LAYERS, TEXELS = 29, 2048
"""Of its opacity maps, at least, and of them texels along a side."""
FINEST = 6
"""Level of curves where a tolerance decides."""
PATIENCE = 40.0
"""Seconds for the reference and all settings; those that are left then are not tried."""
ALWAYS = 2
"""Settings that are tried in any case: the finest and the preset's own."""
ADAPTIVE = {"curves.mode": "adaptive", "curves.level": FINEST}


class Pictures(Experiment):
    """Pictures of one preset at many settings, each against one reference, which is finer by far.

    As it is here: windows of the whole frame, at parameters of drawing that make it cheaper or finer, strands and their
    number untouched. Seconds are the processor's, so that other programs do not move the front.
    """

    draws = True
    metric, unit = "rmse", "of the mean of the reference picture"
    what = f"{SAMPLES}×{SAMPLES} samples a pixel, curves within {TOLERANCE} samples, opacity maps of {LAYERS} layers"
    of_processor = True
    stages: tuple[str, ...] = ()
    """Those whose time counts; none: all."""
    references = 1
    windows: Windows

    def __init__(self, request: Request) -> None:
        self.request = request
        self.subject = self.opened(request)
        scene = self.subject.scene
        size = "×".join(map(str, scene.image.size))
        strands, every = scene.emitter.strands, self.subject.all_strands
        of_all = "" if strands == every else f" of {every}"
        self.title = f"{request.name}, {strands}{of_all} strands at {size}: {self.axis}"

    def opened(self, request: Request) -> Subject:
        """What is drawn."""
        if request.strands is not None:
            raise UsageError(f"--strands: axis {self.axis} draws all of them; use --set emitter.strands")
        scene = request.single if request.size is None else changed(request.single, {"image.size": request.size})
        self.request = Request(scene=scene, name=request.name, frame=request.frame, fixed=request.fixed)
        self.windows = Windows(self.request)
        self.windows.of_processor = self.of_processor
        return self.windows

    @property
    def scene(self) -> Scene:
        """The preset at the size that is studied."""
        return self.subject.scene

    @abstractmethod
    def choices(self) -> Sequence[Parameters]:
        """Settings to be tried. Those that the program does not have are left out by `settings`."""

    def series(self, parameters: Parameters) -> str:
        """The line of the chart that a setting belongs to."""
        return str(parameters.get("image.resolver", self.scene.image.resolver))

    def settings(self) -> list[Parameters]:
        """The choices that there are, and that leave what was set by hand as it is. Raises `UsageError` for none."""
        scene = self.scene
        found = []
        for parameters in self.choices():
            paths = self.paths(parameters)
            own = {path: value for path, value in paths.items() if path in self.request.fixed}
            if all(knows(scene, path, value) for path, value in paths.items()) and all(
                value_at(scene, path) == value for path, value in own.items()
            ):
                found.append(parameters)
        if not found:
            raise UsageError(f"--set: leaves nothing to be tried of {self.axis}; set fewer of its parameters")
        return found

    def paths(self, parameters: Parameters) -> Parameters:
        """The settings by dotted path that a choice stands for."""
        return parameters

    def prepare(self, step: Callable[[str], None]) -> dict[str, Any]:
        """Move the strands, and draw the reference."""
        self.subject.move()
        found = self.reference()
        step(f"{self.subject.name}: reference")
        return {
            "name": self.subject.name, "frame": self.subject.frame, "size": list(self.scene.image.size),
            "strands": self.scene.emitter.strands, "width_given": self.subject.widened, **found,
        }  # fmt: skip

    def converged(self) -> dict[str, Any]:
        """The settings of the reference: sorted, which converges sooner, and with no fewer layers than the preset
        has."""
        fine: dict[str, Any] = {"image.resolver": "sorted", "image.supersample": SAMPLES, "detail": None}
        fine |= {**ADAPTIVE, "curves.tolerance": TOLERANCE}
        for i in shadowed(self.scene):
            layers = max(LAYERS, self.scene.lights[i].shadow.layers)
            fine |= {f"lights.{i}.shadow.model": "opacity", f"lights.{i}.shadow.layers": layers}
            fine[f"lights.{i}.shadow.size"] = TEXELS
        return fine

    def reference(self) -> dict[str, Any]:
        """Draw the reference, and learn what a whole frame takes."""
        self.fine = self.windows.draw(changed(self.scene, self.converged()))
        words = "; seconds are the processor's, of a whole frame" if self.of_processor else ""
        return {
            "what": self.what + words, "mean": self.windows.mean, "counts": self.fine.counts,
            "windows": [list(window) for window in self.windows.windows], "own_seconds": self.windows.calibrate(),
            "width": self.width_given(),
        }  # fmt: skip

    def width_given(self) -> dict[str, float]:
        """The settings that give lines of no width the width of the reference; nothing for other strands."""
        if not self.windows.widened:
            return {}
        return {"material.width": self.scene.material.width, "material.taper": self.scene.material.drawn_taper}

    def errors(self, parameters: Parameters, picture: Picture) -> dict[str, float | None]:
        """Of the windows: root mean square difference of their light from the reference's, a share of the mean light of
        all of the frame that has strands, and mean ꟻLIP of their pixels."""
        fine, windows = self.fine, self.windows
        assert picture.pixels is not None
        assert fine.pixels is not None
        off = float(np.sqrt(((picture.image - fine.image) ** 2).mean()))
        pairs = zip(windows.apart(fine.pixels), windows.apart(picture.pixels), strict=True)
        flip = float(np.mean([mean_flip(one, other) for one, other in pairs]))
        return {"rmse": off / windows.mean if windows.mean > 0 else None, "flip": flip}

    def measure(self, parameters: Parameters) -> Point:
        """Draw one setting."""
        picture = self.subject.draw(changed(self.scene, self.paths(parameters)))
        return self.point(parameters, picture, self.errors(parameters, picture))

    def point(self, parameters: Parameters, picture: Picture, error: dict[str, float | None]) -> Point:
        """The figures of a setting."""
        seconds = sum(took for stage, took in picture.seconds.items() if not self.stages or stage in self.stages)
        return Point(parameters, seconds, error, series=self.series(parameters), counts=picture.counts)


class FrameStudy(Pictures):
    """What `render --max-error` chooses by: as many settings as there is time for."""

    axis = "frame"
    of_processor = False

    def choices(self) -> list[Parameters]:
        """The finest, so that what can be reached is known however long the rest take; the preset's own settings, the
        qualities, and samples and tolerances between them."""
        draft, default, best = (settings_for(name, self.scene) for name in ("draft", "default", "best"))
        fine: dict[str, Any] = {"image.resolver": "sorted", **ADAPTIVE}
        fine |= {f"lights.{i}.shadow.model": "opacity" for i in shadowed(self.scene)}

        def made(samples: int, tolerance: float) -> dict[str, Any]:
            return {**fine, "image.supersample": samples, "curves.tolerance": tolerance}

        finest = {**self.converged(), "image.supersample": SAMPLES // 2}
        found: list[Parameters] = [finest, {}, made(4, 0.05), made(2, 0.05), best, default]
        found += [made(1, 0.05), made(6, 0.05), made(3, 0.05), made(2, 0.25)]
        found += [draft, made(1, 0.25), {**made(1, 1.0), "detail.pixels": 0.25}, {**made(1, 1.0), "detail.pixels": 0.5}]
        if self.scene.image.resolver == "zbuffer":
            found += [{"image.supersample": samples} for samples in (2, 3, 4, 6, 8)]
        return found

    def settings(self) -> list[Parameters]:
        """The choices that are left by what was set by hand, by the look and by the memory that is free."""
        assert self.request.scene is not None
        looks, drawn, found = LOOKS.get(self.scene.look, {}).items(), [], []
        allowed = {path.replace("*", str(i)): values for path, values in looks for i in range(len(self.scene.lights))}
        for parameters in super().settings():
            scene = changed(self.scene, parameters)
            if scene in drawn or any(value not in allowed.get(path, (value,)) for path, value in parameters.items()):
                continue
            with suppress(RefusedError):
                checked_plan(changed(self.request.scene, parameters), (self.windows.frame,))
                drawn.append(scene)
                found.append(parameters)
        return found

    def reference(self) -> dict[str, Any]:
        """As in `Pictures`; time runs from here on."""
        self._began, self._measured = time.monotonic(), 0
        return super().reference()

    def measure(self, parameters: Parameters) -> Point:
        """Draw one setting; after `PATIENCE` none but the first two, and the point has no error."""
        self._measured += 1
        if self._measured <= ALWAYS or time.monotonic() - self._began <= PATIENCE:
            return super().measure(parameters)
        return Point(parameters, 0.0, {"rmse": None, "flip": None}, series=self.series(parameters))


class CoverageStudy(Pictures):
    """Samples and resolvers of `image`, all other settings as the preset has them."""

    axis = "coverage"
    what = f"{SAMPLES}×{SAMPLES} samples a pixel, sorted"

    def choices(self) -> list[Parameters]:
        """Every resolver with its own useful range of samples."""
        out: list[Parameters] = [{"image.resolver": "zbuffer", "image.supersample": n} for n in (1, 2, 3, 4, 6, 8)]
        return out + [{"image.resolver": "sorted", "image.supersample": n} for n in (1, 2, 3, 4)]

    def converged(self) -> dict[str, Any]:
        """The settings of the reference."""
        return {"image.resolver": "sorted", "image.supersample": SAMPLES}


class QualityStudy(Pictures):
    """The three by name, and samples, tolerances and levels of detail about them, all of the settings of `default`
    else."""

    axis = "quality"

    def choices(self) -> list[Parameters]:
        """Those by name, then the grid."""
        found: list[Parameters] = [{"quality": name} for name in ("preset", *QUALITIES)]
        samples, tolerances = (1, 2, 3, 4, 6), (0.1, 0.25, 1.0)
        found += [
            {**ADAPTIVE, **parameters}
            for parameters in grid({"image.supersample": samples, "curves.tolerance": tolerances})
        ]
        return found + [{**ADAPTIVE, "curves.tolerance": 1.0, "detail.pixels": pixels} for pixels in (0.25, 0.5, 0.75)]

    def paths(self, parameters: Parameters) -> Parameters:
        """Of a name what it stands for; of the grid what it changes of `default`."""
        name = parameters.get("quality", "default")
        own = {} if name == "preset" else settings_for(name, self.scene)
        return {**own, **{path: value for path, value in parameters.items() if path != "quality"}}

    def series(self, parameters: Parameters) -> str:
        """By name, or of the grid."""
        return "by name" if "quality" in parameters else "grid"
