"""Tables of a strand's light against quadrature in double precision, and against doing without tables."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np

from ...errors import UsageError
from ..axes import Axis, Request
from ..points import Knobs, Point
from .experiment import Pictures
from .optics import STEEP, optics_of
from .subject import Picture, differences

ROWS, COLUMNS = 40, 24
"""Pairs of inclinations, and angles about the strand for each, at which values are compared."""


class TableStudy(Pictures):
    """Sizes of the tables; and the number of offsets h in an integral for every vertex."""

    axis = "tables"
    metric, unit, stages = "rms", "of the mean value", ("shade",)

    def __init__(self, request: Request) -> None:
        super().__init__(request)
        material = self.scene.material
        if material.specular == 0:
            raise UsageError(f"{request.name}: material.specular is 0, so there are no tables to be studied")
        optics = optics_of(material)
        if optics is None:
            raise UsageError(f"{request.name}: the fibre model {material.model} says nothing that could be studied")
        self.optics = optics
        self.title += f" of {self.optics.name}'s model"

    def choices(self) -> list[Knobs]:
        """Tables from coarse to fine; direct evaluation with few and many offsets."""
        out: list[Knobs] = [{"theta": theta, "phi": phi} for theta, phi in self.optics.sizes]
        return out + [{"h": nodes} for nodes in (4, 16, 32, 64, 128, 256)]

    def settings(self) -> list[Knobs]:
        """All of them: none is a preset's own."""
        return self.choices()

    def series(self, knobs: Knobs) -> str:
        """Tables or none."""
        return "direct" if "h" in knobs else "tables"

    def reference(self) -> dict[str, Any]:
        """Quadrature in double precision at directions near the lobes; and the picture with the finest tables."""
        rng = np.random.default_rng(0)
        theta_h = 1.5 * self.optics.spread * rng.standard_normal(ROWS)
        theta_d = STEEP * (2 * rng.random(ROWS) - 1)
        phi = math.pi * (np.arange(COLUMNS) + rng.random((ROWS, COLUMNS))) / COLUMNS
        self.angles = np.clip(theta_h - theta_d, -STEEP, STEEP), np.clip(theta_h + theta_d, -STEEP, STEEP), phi
        self.exact = self.optics.truth(self.angles)
        finest = self.optics.tables(*self.optics.finest)
        self.finest = self.subject.draw(self.scene, tables=finest, keep_shading=True)
        lights = sum(light.intensity > 0 for light in self.scene.lights)
        self.lit = lights * sum(int(np.isfinite(colours[:, 0]).sum()) for _, colours in self.finest.shaded)
        return {"what": f"quadrature in double precision at {ROWS * COLUMNS} directions",
                "mean": float(self.exact.mean()), "evaluations": self.lit}  # fmt: skip

    def measure(self, knobs: Knobs) -> Point:
        """Tables: built, looked up, and drawn with. None: the integral for as many vertices and lights."""
        if "h" in knobs:
            return self._direct(knobs)
        began = time.perf_counter()
        tables = self.optics.tables(knobs["theta"], knobs["phi"])
        built = time.perf_counter() - began
        picture = self.subject.draw(self.scene, tables=tables)
        error = _named(differences(self.optics.look_up(tables, self.angles), self.exact))
        error |= self.errors(knobs, picture)
        point = self.point(knobs, Picture(picture.image, {"shade": picture.seconds["shade"] + built}, {}), error)
        point.counts = {"bytes": tables.nbytes, "build_us": round(1e6 * built)}
        return point

    def errors(self, knobs: Knobs, picture: Picture) -> dict[str, float | None]:
        """Of the picture against that with the finest tables, and of the light that white tables hold."""
        return {"picture": differences(picture.image, self.finest.image)["rmse"],
                "furnace": self.optics.furnace(knobs["theta"], knobs["phi"])}  # fmt: skip

    def _direct(self, knobs: Knobs) -> Point:
        times = []
        for _ in range(3):
            began = time.perf_counter()
            out = self.optics.integrate(self.angles, knobs["h"])
            times.append(time.perf_counter() - began)
        seconds = min(times) * self.lit / len(out)
        found = self.scene.material.specular * out.reshape(self.exact.shape)
        error = _named(differences(found, self.exact))
        return Point(knobs=knobs, seconds=seconds, error=error, series="direct", counts={"evaluations": self.lit})


def _named(error: dict[str, float | None]) -> dict[str, float | None]:
    return {"rms" if name == "rmse" else name: value for name, value in error.items()}


AXIS = Axis(
    name="tables",
    doc="sizes of the tables of Marschner's or Chiang's model, and none, against quadrature in double precision",
    knobs=("theta", "phi", "h"),
    metric="rms",
    of_preset=True,
    open=TableStudy,
    pictures=True,
)
