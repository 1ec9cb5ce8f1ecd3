"""Lights and their shadow maps."""

# ruff: noqa: RUF009 - these calls make dataclass fields

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...common.registry import SHADOWS
from ..fields import Colour, Vector, choice, colour, file, integer, model, number, parameters, vector


@dataclass(frozen=True, slots=True, repr=False)
class Shadow:
    """Shadows of strands in one light: by the thesis' map (§3, corrected), or a deep opacity map."""

    model: str = choice("minmax", SHADOWS, doc="minmax: depth range per texel; opacity: deep opacity map; off: none")
    size: int | None = integer(
        None, low=1, high=8192, unit="texels",
        doc="texels per side, for opacity at most; absent: 512, for opacity 1024",
    )  # fmt: skip
    layers: int = integer(31, low=1, high=61, doc="layers of an opacity map")
    texel: float | None = number(
        None, above=0, unit="m", doc="size of a texel of an opacity map; absent: from the spacing of strands"
    )
    bias: float = number(0.0, low=0, unit="m", doc="depth bias")
    parameters: Any = parameters(SHADOWS, "model", doc="settings of a model of another package; absent: its defaults")


@dataclass(frozen=True, slots=True, repr=False)
class DirectionalLight:
    """Light from infinitely far, like the sun."""

    kind: str = choice("directional", ("directional",))
    direction: Vector = vector((-0.5, -1.0, -0.5), unit="1", nonzero=True, doc="direction in which light travels")
    colour: Colour = colour((1.0, 1.0, 1.0), doc="colour")
    intensity: float = number(3.0, low=0, doc="irradiance on a surface that faces it")
    size: float = number(
        0.0, low=0, high=90, unit="deg", doc="angular diameter, 0.53 for the sun: solids get soft shadows"
    )
    shadow: Shadow = model(Shadow, doc="the strands' shadow map")


@dataclass(frozen=True, slots=True, repr=False)
class PointLight:
    """Light from a point, falling off with the square of the distance."""

    kind: str = choice("point", ("point",))
    position: Vector = vector((3.0, 3.0, 3.0), unit="m", doc="position of the light")
    colour: Colour = colour((1.0, 1.0, 1.0), doc="colour")
    intensity: float = number(30.0, low=0, unit="W/sr", doc="irradiance at one metre")
    size: float = number(0.0, low=0, unit="m", doc="diameter: solids get soft shadows")
    shadow: Shadow = model(Shadow, doc="the strands' shadow map")


Light = DirectionalLight | PointLight
MOST_LIGHTS = 256
"""Lights of a preset at the most: each is drawn into a shadow map of its own, and met by every strand."""
LIGHTS = {"directional": DirectionalLight, "point": PointLight}


@dataclass(frozen=True, slots=True, repr=False)
class AmbientOcclusion:
    """Occlusion of `ambient` and `environment` by strands and solids, computed on a grid."""

    cells: int = integer(40_000, low=1728, high=20_000_000, doc="approximate number of grid cells")
    directions: int = integer(32, low=2, high=1024, doc="directions of light")


@dataclass(frozen=True, slots=True, repr=False)
class Environment:
    """Light from a lat-long picture, which is not drawn; `ambient_occlusion` shades it."""

    image: str = file("picture", doc="lat-long picture (PNG, JPEG or Radiance .hdr) whose middle is at +z")
    intensity: float = number(1.0, low=0, doc="scale")
    rotation: float = number(0.0, unit="deg", doc="rotation about +y")
