"""Fibre models as the study of their tables sees them: built, read, integrated, exact."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...draw.fibre import chiang, marschner
from ...draw.fibre.kernels import chiang as chiang_kernel
from ...draw.fibre.kernels import lobes
from ...draw.fibre.kernels import marschner as marschner_kernel
from ...draw.fibre.tables import FibreTables
from ...registry import FIBRES
from ...scene.model import Material
from .. import bsdf_reference, chiang_reference
from ..kernels import direct

AXIS = np.float32(0.0), np.float32(0.0), np.float32(1.0)
NO_EXTRA = np.float32(0.0), np.float32(0.0), np.float32(0.0)
STEEP = math.radians(75)
"""Inclinations up to here."""
Angles = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]
"""θ_l (rows,), θ_v (rows,) and φ (rows, columns), radians."""


class Optics(ABC):
    """One model with one material."""

    name = ""
    sizes: tuple[tuple[int, int], ...] = ()
    """Nodes over θ and over φ, from coarse to fine."""
    finest: tuple[int, int] = (0, 0)

    def __init__(self, material: Material) -> None:
        self.material = material
        self.sigma: NDArray[np.float64] = self.tables(*self.finest).absorption

    @property
    @abstractmethod
    def spread(self) -> float:
        """Radians: about how wide the lobes are along the strand."""

    @abstractmethod
    def tables(self, theta: int, phi: int) -> Any:
        """The renderer's tables of that size."""

    @abstractmethod
    def read(self, tables: Any, light: Any, eye: Any) -> Any:
        """What the renderer reads from them for two unit directions about a strand along z: red, green and blue."""

    @abstractmethod
    def exact(self, channel: int, theta_l: float, theta_v: float, phi: NDArray[np.float64]) -> NDArray[np.float64]:
        """S cos θ_l by quadrature in double precision."""

    @abstractmethod
    def integrate(self, angles: Angles, nodes: int) -> NDArray[np.float64]:
        """The same without tables, by so many offsets, (rows · columns, 3)."""

    @abstractmethod
    def kept(self, tables: Any, row: int, angle: float) -> float:
        """Of what white tables have to hold over the circle at an inclination, the share that they hold."""

    def look_up(self, tables: Any, angles: Angles) -> NDArray[np.float64]:
        """(rows, columns, 3) what the renderer reads from its tables."""
        theta_l, theta_v, phi = angles
        out = np.empty((*phi.shape, 3))
        for i, j in np.ndindex(phi.shape):
            light = (math.cos(theta_l[i]), 0.0, math.sin(theta_l[i]))
            eye = (math.cos(theta_v[i]) * math.cos(phi[i, j]), math.cos(theta_v[i]) * math.sin(phi[i, j]),
                   math.sin(theta_v[i]))  # fmt: skip
            out[i, j] = self.read(tables, map(np.float32, light), map(np.float32, eye))
        return out

    def truth(self, angles: Angles) -> NDArray[np.float64]:
        """(rows, columns, 3) as `exact`, with the material's scale."""
        theta_l, theta_v, phi = angles
        out = np.empty((*phi.shape, 3))
        for i, c in np.ndindex(len(phi), 3):
            out[i, :, c] = self.exact(c, float(theta_l[i]), float(theta_v[i]), phi[i])
        return self.material.specular * out

    def furnace(self, theta: int, phi: int) -> float:
        """Greatest share of light that white tables lose or make over the circle, inclinations up to `STEEP`."""
        plain = replace(
            self.material, colour=(1.0, 1.0, 1.0), tip_colour=None, colour_variation=0.0, pigment="rgb",
            eumelanin=None, pheomelanin=None, grey=0.0,
        )  # fmt: skip
        white = type(self)(plain)
        tables = white.tables(theta, phi)
        angles = np.linspace(0, 0.5 * math.pi, theta)
        return max(abs(white.kept(tables, row, float(a)) - 1) for row, a in enumerate(angles) if a <= STEEP)


class Marschner(Optics):
    """Marschner's lobes."""

    name = "Marschner"
    sizes = ((8, 12), (16, 24), (24, 48), (32, 64), (48, 64), (48, 96), (96, 96), (96, 192))
    finest = (192, 384)

    @property
    def spread(self) -> float:
        """That of R."""
        return math.radians(self.material.beta)

    def tables(self, theta: int, phi: int) -> FibreTables:
        """Of `draw.marschner`."""
        tables = marschner.build_tables(self.material, theta, phi)
        assert tables is not None
        return tables

    def read(self, tables: Any, light: Any, eye: Any) -> Any:
        """By the kernel."""
        return marschner_kernel.marschner(AXIS, tuple(light), tuple(eye), tables.arrays, NO_EXTRA)

    def _fibre(self, sigma: float) -> bsdf_reference.Fibre:
        m = self.material
        return bsdf_reference.Fibre(
            m.eta, math.radians(m.alpha), math.radians(m.beta), math.radians(m.azimuthal), sigma
        )

    def exact(self, channel: int, theta_l: float, theta_v: float, phi: NDArray[np.float64]) -> NDArray[np.float64]:
        """By `study.bsdf_reference`."""
        return bsdf_reference.scattering(self._fibre(float(self.sigma[channel])), theta_l, theta_v, phi)

    def integrate(self, angles: Angles, nodes: int) -> NDArray[np.float64]:
        """By `kernels.direct`."""
        m, out = self.material, np.empty((angles[2].size, 3))
        direct.marschner(
            *_flat(angles), m.eta, math.radians(m.alpha), math.radians(m.beta), math.radians(m.azimuthal), self.sigma,
            nodes, out,
        )  # fmt: skip
        return out

    def kept(self, tables: Any, row: int, angle: float) -> float:
        """Against ½ ∫ Σ A dh, which holds no detector."""
        scale = 0.5 * self.material.specular / (math.sqrt(2 * math.pi) * self.spread)
        sums = [np.trapezoid(tables.nodes[row, :, c], dx=math.pi / (tables.nodes.shape[1] - 1)) / scale * width
                for c, width in ((lobes.R, 1), (lobes.TT, 0.5), (lobes.TRT, 2))]  # fmt: skip
        gamma, weights = bsdf_reference.quadrature(8)
        fibre = self._fibre(0.0)
        right = sum(float(weights @ bsdf_reference.attenuation(p, fibre, angle, gamma)) for p in range(3))
        return float(2 * sum(sums)) / right


class Chiang(Optics):
    """Chiang's lobes, and what is left after them."""

    name = "Chiang"
    sizes = ((8, 16), (16, 32), (32, 64), (64, 64), (64, 128), (64, 256))
    finest = (192, 512)

    @property
    def spread(self) -> float:
        """That of R."""
        return math.sqrt(float(chiang.variances(self.material.beta_m)[0]))

    def tables(self, theta: int, phi: int) -> FibreTables:
        """Of `draw.chiang`."""
        tables = chiang.build_tables(self.material, theta, phi)
        assert tables is not None
        return tables

    def read(self, tables: Any, light: Any, eye: Any) -> Any:
        """By the kernel."""
        return chiang_kernel.chiang(AXIS, tuple(light), tuple(eye), tables.arrays, NO_EXTRA)

    def exact(self, channel: int, theta_l: float, theta_v: float, phi: NDArray[np.float64]) -> NDArray[np.float64]:
        """By `study.chiang_reference`."""
        m = self.material
        hair = chiang_reference.Hair(m.beta_m, m.beta_n, m.tilt, float(self.sigma[channel]), m.eta)
        return chiang_reference.scattering(hair, theta_l, theta_v, phi)

    def integrate(self, angles: Angles, nodes: int) -> NDArray[np.float64]:
        """By `kernels.direct`."""
        m, out = self.material, np.empty((angles[2].size, 3))
        direct.chiang(
            *_flat(angles), m.eta, chiang.variances(m.beta_m), chiang.tilts(m.tilt), chiang.logistic_scale(m.beta_n),
            self.sigma, nodes, out,
        )  # fmt: skip
        return out

    def kept(self, tables: Any, row: int, angle: float) -> float:
        """All of it is there, since nothing is absorbed."""
        values = sum(tables.nodes[row, :, c].astype(np.float64) for c in (lobes.R, lobes.TT, lobes.TRT, lobes.REST))
        return float(2 * np.trapezoid(values, dx=math.pi / (tables.nodes.shape[1] - 1)))


def _flat(angles: Angles) -> Angles:
    theta_l, theta_v, phi = angles
    return (np.broadcast_to(theta_l[:, None], phi.shape).ravel(), np.broadcast_to(theta_v[:, None], phi.shape).ravel(),
            phi.ravel())  # fmt: skip


MODELS: dict[str, Callable[[Material], Optics]] = {"marschner": Marschner, "chiang": Chiang}
"""Of the shipped models."""


def optics_of(material: Material) -> Optics | None:
    """A material's model as studies see it: a shipped one, or what a model from elsewhere gives as ``optics``; None
    where it gives nothing."""
    if material.model in MODELS:
        return MODELS[material.model](material)
    own: Callable[[Material], Optics] | None = getattr(FIBRES[material.model], "optics", None)
    return None if own is None else own(material)
