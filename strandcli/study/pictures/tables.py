"""Tables of the Marschner model against quadrature in double precision, and against doing without tables."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...draw.kernels import marschner as kernel
from ...draw.marschner import MarschnerTables, build_tables
from ...errors import UsageError
from .. import bsdf_reference as truth
from ..axes import Axis, Request
from ..kernels import direct
from ..points import Knobs, Point
from .experiment import Pictures
from .subject import Picture, differences

ROWS, COLUMNS = 40, 24
"""Pairs of inclinations, and angles about the strand for each, at which values are compared."""
FINEST = (192, 384)
STEEP = math.radians(75)
"""Inclinations up to here."""


class TableStudy(Pictures):
    """Sizes of the tables; and the number of offsets h in an integral for every vertex."""

    axis = "tables of the Marschner model"
    metric, unit, stages = "rms", "of the mean value", ("shade",)

    def __init__(self, request: Request) -> None:
        super().__init__(request)
        material = self.scene.material
        if getattr(material, "model", "marschner") != "marschner" or material.specular == 0:
            raise UsageError(f"{request.name}: draws without Marschner's tables; its material has none to be studied")

    def choices(self) -> list[Knobs]:
        """Tables from coarse to fine; direct evaluation with few and many offsets."""
        out: list[Knobs] = [{"theta": a, "phi": b} for a, b in ((8, 12), (16, 24), (24, 48), (32, 64), (48, 64),
                                                                   (48, 96), (96, 96), (96, 192))]  # fmt: skip
        return out + [{"h": nodes} for nodes in (4, 16, 64, 128, 256)]

    def settings(self) -> list[Knobs]:
        """All of them: none is a preset's own."""
        return self.choices()

    def series(self, knobs: Knobs) -> str:
        """Tables or none."""
        return "direct" if "h" in knobs else "tables"

    def reference(self) -> dict[str, Any]:
        """Quadrature in double precision at directions near the lobes; and the picture with the finest tables."""
        material = self.scene.material
        rng = np.random.default_rng(0)
        theta_h = math.radians(1.5 * material.beta) * rng.standard_normal(ROWS)
        theta_d = STEEP * (2 * rng.random(ROWS) - 1)
        self.theta_l = np.clip(theta_h - theta_d, -STEEP, STEEP)
        self.theta_v = np.clip(theta_h + theta_d, -STEEP, STEEP)
        self.phi = math.pi * (np.arange(COLUMNS) + rng.random((ROWS, COLUMNS))) / COLUMNS
        finest = self._tables(*FINEST)
        self.sigma = finest.absorption
        self.exact = np.empty((ROWS, COLUMNS, 3))
        for c in range(3):
            one = truth.Fibre(material.eta, math.radians(material.alpha), math.radians(material.beta),
                              math.radians(material.azimuthal), float(self.sigma[c]))  # fmt: skip
            for i in range(ROWS):
                self.exact[i, :, c] = truth.scattering(one, self.theta_l[i], self.theta_v[i], self.phi[i])
        self.exact *= material.specular
        parts = (finest.nodes, finest.lobes, finest.paths)
        self.finest = self.subject.draw(self.scene, tables=parts, keep_shading=True)
        lights = sum(light.intensity > 0 for light in self.scene.lights)
        self.lit = lights * sum(int(np.isfinite(colours[:, 0]).sum()) for _, colours in self.finest.shaded)
        return {"what": f"quadrature in double precision at {ROWS * COLUMNS} directions",
                "mean": float(self.exact.mean()), "evaluations": self.lit}  # fmt: skip

    def measure(self, knobs: Knobs) -> Point:
        """Tables: built, looked up, and drawn with. None: the integral for as many vertices and lights."""
        if "h" in knobs:
            return self._direct(knobs)
        began = time.perf_counter()
        tables = self._tables(knobs["theta"], knobs["phi"])
        built = time.perf_counter() - began
        picture = self.subject.draw(self.scene, tables=(tables.nodes, tables.lobes, tables.paths))
        found = np.empty_like(self.exact)
        for i in range(ROWS):
            for j in range(COLUMNS):
                found[i, j] = self._looked_up(tables, self.theta_l[i], self.theta_v[i], self.phi[i, j])
        error = _named(differences(found, self.exact))
        error["picture"] = differences(picture.image, self.finest.image)["rmse"]
        error["furnace"] = self._furnace(knobs["theta"], knobs["phi"])
        point = self.point(knobs, Picture(picture.image, {"shade": picture.seconds["shade"] + built}, {}), error)
        point.counts = {"bytes": tables.nbytes, "build_us": round(1e6 * built)}
        return point

    def _tables(self, theta: int, phi: int) -> MarschnerTables:
        tables = build_tables(self.scene.material, theta, phi)
        assert tables is not None
        return tables

    def _looked_up(self, tables: MarschnerTables, theta_l: float, theta_v: float, phi: float) -> Any:
        f = np.float32
        light = (math.cos(theta_l), 0.0, math.sin(theta_l))
        eye = (math.cos(theta_v) * math.cos(phi), math.cos(theta_v) * math.sin(phi), math.sin(theta_v))
        return kernel.marschner(f(0), f(0), f(1), *map(f, light), *map(f, eye), tables.lobes, tables.nodes,
                                None, f(0), f(0), f(0))  # fmt: skip

    def _furnace(self, theta: int, phi: int) -> float:
        """Greatest share of light that white tables lose or make over the circle, inclinations up to `STEEP`: against
        ½ ∫ Σ A dh, which holds no detector."""
        white = replace(self.scene.material, colour=(1.0, 1.0, 1.0), tip_colour=None, colour_variation=0.0)
        tables = build_tables(white, theta, phi)
        assert tables is not None
        peaks = [0.5 * white.specular / (math.sqrt(2 * math.pi) * math.radians(white.beta) * w) for w in (1, 0.5, 2)]
        gamma, weights = truth.quadrature(8)
        worst = 0.0
        for row, angle in enumerate(np.linspace(0, 0.5 * math.pi, theta)):
            if angle > STEEP:
                break
            sums = [np.trapezoid(tables.nodes[row, :, c], dx=math.pi / (phi - 1)) for c in (0, 1, 4)]
            got = 2 * sum(one / peak for one, peak in zip(sums, peaks, strict=True))
            fibre = truth.Fibre(white.eta, 0.0, 1.0, math.radians(white.azimuthal), 0.0)
            right = sum(float(weights @ truth.attenuation(p, fibre, angle, gamma)) for p in range(3))
            worst = max(worst, abs(float(got) / right - 1))
        return worst

    def _direct(self, knobs: Knobs) -> Point:
        material = self.scene.material
        shape = self.phi.shape
        arguments = (
            np.broadcast_to(self.theta_l[:, None], shape).ravel(),
            np.broadcast_to(self.theta_v[:, None], shape).ravel(),
            self.phi.ravel(), material.eta, math.radians(material.alpha), math.radians(material.beta),
            math.radians(material.azimuthal), self.sigma, knobs["h"],
        )  # fmt: skip
        out: NDArray[np.float64] = np.empty((self.phi.size, 3))
        times = []
        for _ in range(3):
            began = time.perf_counter()
            direct.scattering(*arguments, out)
            times.append(time.perf_counter() - began)
        seconds = min(times) * self.lit / len(out)
        error = _named(differences(material.specular * out.reshape(*shape, 3), self.exact))
        return Point(knobs=knobs, seconds=seconds, error=error, series="direct", counts={"evaluations": self.lit})


def _named(error: dict[str, float | None]) -> dict[str, float | None]:
    return {"rms" if name == "rmse" else name: value for name, value in error.items()}


AXIS = Axis(
    name="tables",
    doc="sizes of the Marschner model's tables, and none, against quadrature in double precision",
    knobs=("theta", "phi", "h"),
    metric="rms",
    of_preset=True,
    open=TableStudy,
    pictures=True,
)
