"""Axes of pictures: what each approximation of drawing costs and how far off it is, measured against a reference."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

from ...errors import UsageError
from ...scene.fields import value_at
from ...scene.model import Scene
from ..points import Parameters, Point
from ..sweep import Experiment, Request, changed, knows
from .subject import Picture, Subject


class Pictures(Experiment):
    """Pictures of one preset at many settings, each against one reference, which is finer by far."""

    draws = True
    metric, unit = "rmse", "of the mean of the reference picture"
    stages: tuple[str, ...] = ()
    """Those whose time counts; none: all."""
    references = 1

    def __init__(self, request: Request, subject: Subject | None = None) -> None:
        """``subject``: what is drawn; by default the first strands, small."""
        self.request = request
        self.subject = subject or Subject(request)
        scene = self.subject.scene
        size = "×".join(map(str, scene.image.size))
        strands, every = scene.emitter.strands, self.subject.all_strands
        of_all = "" if strands == every else f" of {every}"
        self.title = f"{request.name}, {strands}{of_all} strands at {size}: {self.axis}"

    @property
    def scene(self) -> Scene:
        """The preset at the size that is studied."""
        return self.subject.scene

    @abstractmethod
    def choices(self) -> Sequence[Parameters]:
        """Settings to be tried. Those that the program does not have are left out by `settings`."""

    @abstractmethod
    def series(self, parameters: Parameters) -> str:
        """The line of the chart that a setting belongs to."""

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

    @abstractmethod
    def reference(self) -> dict[str, Any]:
        """Make the reference; what the report says of it, ``what`` for people."""

    def measure(self, parameters: Parameters) -> Point:
        """Draw one setting."""
        picture = self.subject.draw(changed(self.scene, self.paths(parameters)))
        return self.point(parameters, picture, self.errors(parameters, picture))

    @abstractmethod
    def errors(self, parameters: Parameters, picture: Picture) -> dict[str, float | None]:
        """How far a picture of these settings is off."""

    def point(self, parameters: Parameters, picture: Picture, error: dict[str, float | None]) -> Point:
        """The figures of a setting."""
        seconds = sum(took for stage, took in picture.seconds.items() if not self.stages or stage in self.stages)
        return Point(parameters, seconds, error, series=self.series(parameters), counts=picture.counts)
