"""What strands look like: how they take light, how smooth they are, and how many are drawn."""

# ruff: noqa: RUF009 - these calls make dataclass fields

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...registry import FIBRES
from .. import fields
from ..fields import Colour, boolean, choice, colour, integer, number, parameters

PIGMENTS = (
    "rgb", "black", "dark_brown", "brown", "light_brown", "auburn", "red", "dark_blond", "blond", "platinum", "white",
)  # fmt: skip


TAPER = 0.7
"""Part of the width that strands lose from root to tip where neither a preset nor a file says so."""


@dataclass(frozen=True, slots=True, repr=False)
class Material:
    """How strands take light: Marschner et al. 2003 (R, TT and TRT lobes) or Chiang et al. 2016 (those and the rest,
    energy conserving), and an approximation of the light that goes from strand to strand, which both leave out."""

    model: str = choice(
        "marschner",
        FIBRES,
        doc="marschner: alpha, beta, azimuthal; chiang, the model of path tracers: tilt, beta_m, beta_n",
    )
    parameters: Any = parameters(FIBRES, "model", doc="settings of a model from elsewhere; absent: its defaults")
    colour: Colour = colour((0.22, 0.11, 0.05), doc="colour of a mass of such strands, where pigment is rgb")
    # inside this class `colour` is by now the field above
    tip_colour: Colour | None = fields.colour(None, doc="colour at the tip; absent: the same along the strand")
    pigment: str = choice("rgb", PIGMENTS, doc="rgb: as `colour`; or hair of a natural colour, made by melanin")
    eumelanin: float | None = number(
        None, low=0, high=50, doc="black-brown melanin, 1 is brown; with pheomelanin in place of a pigment's own"
    )
    pheomelanin: float | None = number(None, low=0, high=50, doc="red-yellow melanin")
    grey: float = number(0.0, low=0, high=1, doc="share of strands without any pigment")
    grey_colour: Colour = fields.colour((1.0, 1.0, 1.0), doc="colour of a mass of those: withered grass, say")
    colour_variation: float = number(0.0, low=0, high=1, doc="spread of brightness from strand to strand")
    eta: float = number(1.55, above=1, high=3, doc="index of refraction")
    alpha: float = number(-7.5, low=-20, high=20, unit="deg", doc="shift of the R lobe toward the root, by the scales")
    beta: float = number(7.5, low=0.1, high=45, unit="deg", doc="longitudinal width of the R lobe (standard deviation)")
    azimuthal: float = number(12.0, low=1, high=60, unit="deg", doc="azimuthal roughness (standard deviation)")
    tilt: float = number(2.5, low=-10, high=10, unit="deg", doc="angle at which the scales stand up (chiang)")
    beta_m: float = number(0.25, low=0.001, high=1, doc="longitudinal roughness (chiang)")
    beta_n: float = number(0.3, low=0.001, high=1, doc="azimuthal roughness (chiang)")
    specular: float = number(1.0, low=0, high=10, doc="scale of the lobes together; 0 leaves their tables out")
    scatter: str = choice(
        "diffuse",
        ("diffuse", "dual"),
        doc="light from strand to strand: a diffuse term; or dual scattering, under lights whose shadow.model is "
        "opacity, with Chiang's lobes",
    )
    diffuse: float = number(0.35, low=0, high=10, doc="scale of the diffuse term; 0 leaves it out")
    width: float = number(
        0.0,
        low=0,
        unit="m",
        doc="strand diameter near the root; with the zbuffer drawn only where it exceeds a pixel. 0: lines one pixel "
        "wide",
    )
    rounded: bool = boolean(
        True, doc="light across a strand where it is wider than two pixels; false: its average everywhere"
    )
    taper: float | None = number(
        None,
        low=0,
        high=1,
        doc="part of the width that is lost from root to tip; absent: 0.7, or 0 where the widths are those of a file",
    )
    opacity: float = number(
        1.0, low=0, high=1, doc="share of the light from behind that a strand stops where it covers (sorted)"
    )

    @property
    def drawn_taper(self) -> float:
        """Part of the width that is lost from root to tip."""
        return TAPER if self.taper is None else self.taper


@dataclass(frozen=True, slots=True, repr=False)
class Curves:
    """How a chain of particles becomes a smooth line (thesis §3)."""

    mode: str = choice(
        "adaptive",
        ("adaptive", "fixed", "off", "thinned"),
        doc="adaptive: pieces by screen error; fixed: 2 ** level; off: straight; thinned: straight, without "
        "points that make no difference",
    )
    level: int = integer(2, low=0, high=8, doc="each segment becomes 2 ** level pieces (fixed), at most (adaptive)")
    tolerance: float = number(
        0.25, above=0, unit="px",
        doc="greatest distance of a piece from its curve (adaptive), of a point that is left out (thinned)",
    )  # fmt: skip
    tangents: str = choice(
        "difference",
        ("difference", "printed"),
        doc="central difference, or the source's cross products with its artefact",
    )


@dataclass(frozen=True, slots=True, repr=False)
class Detail:
    """Level of detail: of strands far away fewer are drawn, each one wider by the inverse of the fraction kept there,
    near / distance."""

    near: float | None = number(
        None,
        above=0,
        unit="m",
        doc="nearer than this every strand is drawn; absent: where it is `pixels` wide or wider, by material.width",
    )
    pixels: float = number(
        1.0,
        above=0,
        high=100,
        unit="px",
        doc="width of a strand's root on the screen, in samples, under which fewer are drawn (where near is absent)",
    )
    fraction: float = number(0.1, above=0, high=1, doc="smallest fraction kept, however far")
    widen: bool = boolean(True, doc="widen by 1 / fraction, so that the covered area stays")
