"""Lights and their shadow maps."""

# ruff: noqa: RUF009 - these calls make dataclass fields

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...registry import SHADOWS
from ..fields import Colour, Vector, choice, colour, file, integer, model, number, parameters, vector


@dataclass(frozen=True, slots=True, repr=False)
class Shadow:
    """Strands' shadows on strands in one light: by the source's map (thesis §3, corrected), a deep opacity map, or
    exactly."""

    model: str = choice(
        "minmax",
        SHADOWS,
        doc="minmax: nearest and farthest strand a texel; opacity: layers that count strands; traced: every strand "
        "against all others, and on solids as opacity; nearby: as traced where light gets, as opacity deep in a groom; "
        "off: no shadow map",
    )
    size: int | None = integer(
        None, low=1, high=8192, unit="texels",
        doc="texels along a side; of opacity, at most; absent: 512, of opacity 1024",
    )  # fmt: skip
    layers: int = integer(31, low=1, high=61, doc="layers of opacity")
    texel: float | None = number(
        None, above=0, unit="m", doc="side of a texel of opacity; absent: from the distance between strands"
    )
    bias: float = number(0.0, low=0, unit="m", doc="depth in front of which nothing is shaded")
    parameters: Any = parameters(SHADOWS, "model", doc="settings of a model from elsewhere; absent: its defaults")


@dataclass(frozen=True, slots=True, repr=False)
class DirectionalLight:
    """Light from infinitely far, like the sun."""

    kind: str = choice("directional", ("directional",))
    direction: Vector = vector((-0.5, -1.0, -0.5), unit="1", nonzero=True, doc="where the light travels to")
    colour: Colour = colour((1.0, 1.0, 1.0), doc="colour")
    intensity: float = number(3.0, low=0, doc="irradiance on a surface that faces it")
    size: float = number(
        0.0, low=0, high=90, unit="deg", doc="diameter as seen from here, the sun's .53: solids' shadows become soft"
    )
    shadow: Shadow = model(Shadow, doc="the strands' shadow map")


@dataclass(frozen=True, slots=True, repr=False)
class PointLight:
    """Light from a point, falling off with the square of the distance."""

    kind: str = choice("point", ("point",))
    position: Vector = vector((3.0, 3.0, 3.0), unit="m", doc="where it is")
    colour: Colour = colour((1.0, 1.0, 1.0), doc="colour")
    intensity: float = number(30.0, low=0, unit="W/sr", doc="irradiance at one metre")
    size: float = number(0.0, low=0, unit="m", doc="its diameter: solids' shadows become soft")
    shadow: Shadow = model(Shadow, doc="the strands' shadow map")


Light = DirectionalLight | PointLight
MOST_LIGHTS = 256
"""Lights of a preset at the most: each is drawn into a shadow map of its own, and met by every strand."""
LIGHTS = {"directional": DirectionalLight, "point": PointLight}


@dataclass(frozen=True, slots=True, repr=False)
class AmbientOcclusion:
    """How much of `ambient` and of the environment strands and solids keep from each other: counted in a grid."""

    cells: int = integer(40_000, low=1728, high=20_000_000, doc="cells of the grid, about")
    directions: int = integer(32, low=2, high=1024, doc="directions that light comes from")


@dataclass(frozen=True, slots=True, repr=False)
class Environment:
    """Light from all round, from a lat-long picture; it is not drawn. `ambient_occlusion` shades it."""

    image: str = file(
        "picture",
        doc="picture, beside the preset: PNG, JPEG (taken as sRGB) or Radiance .hdr; its middle is at +z",
    )
    intensity: float = number(1.0, low=0, doc="scale")
    rotation: float = number(0.0, unit="deg", doc="turn about +y")
