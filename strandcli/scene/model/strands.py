"""What strands look like: how they take light, how smooth they are, and how many are drawn."""

# ruff: noqa: RUF009 - these calls make dataclass fields

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ...common.registry import FIBRES
from .. import fields
from ..fields import Colour, boolean, choice, colour, integer, number, parameters

PIGMENTS = (
    "rgb", "black", "dark_brown", "brown", "light_brown", "auburn", "red", "dark_blond", "blond", "platinum", "white",
)  # fmt: skip


TAPER = 0.7
"""Part of the width that strands lose from root to tip where neither a preset nor a file says so."""


@dataclass(frozen=True, slots=True, repr=False)
class Material:
    """How strands scatter light: by Marschner et al. 2003 or Chiang et al. 2016, and light between strands."""

    model: str = choice(
        "marschner",
        FIBRES,
        doc="marschner uses alpha, beta, azimuthal; chiang uses tilt, beta_m, beta_n",
    )
    parameters: Any = parameters(FIBRES, "model", doc="settings of a model of another package; absent: its defaults")
    colour: Colour = colour((0.22, 0.11, 0.05), doc="colour of many such strands together, if pigment is rgb")
    # inside this class `colour` is by now the field above
    tip_colour: Colour | None = fields.colour(None, doc="colour at the tip; absent: the same along the strand")
    pigment: str = choice("rgb", PIGMENTS, doc="rgb: as `colour`; else a natural hair colour, by melanin")
    eumelanin: float | None = number(None, low=0, high=50, doc="black-brown melanin, 1 is brown; absent: the pigment's")
    pheomelanin: float | None = number(None, low=0, high=50, doc="red-yellow melanin; absent: the pigment's")
    grey: float = number(0.0, low=0, high=1, doc="fraction of strands without pigment")
    grey_colour: Colour = fields.colour((1.0, 1.0, 1.0), doc="colour of those strands, such as withered grass")
    colour_variation: float = number(0.0, low=0, high=1, doc="spread of brightness from strand to strand")
    eta: float = number(1.55, above=1, high=3, doc="index of refraction")
    alpha: float = number(-7.5, low=-20, high=20, unit="deg", doc="shift of the R lobe toward the root, by the scales")
    beta: float = number(7.5, low=0.1, high=45, unit="deg", doc="longitudinal width of the R lobe (standard deviation)")
    azimuthal: float = number(12.0, low=1, high=60, unit="deg", doc="azimuthal roughness (standard deviation)")
    tilt: float = number(2.5, low=-10, high=10, unit="deg", doc="angle at which the scales stand up (chiang)")
    beta_m: float = number(0.25, low=0.001, high=1, doc="longitudinal roughness (chiang)")
    beta_n: float = number(0.3, low=0.001, high=1, doc="azimuthal roughness (chiang)")
    specular: float = number(1.0, low=0, high=10, doc="scale of all lobes; 0: none")
    scatter: str = choice(
        "diffuse",
        ("diffuse", "dual"),
        doc="light between strands. diffuse: a constant term; dual: dual scattering, which needs a light with "
        "`shadow.model: opacity`",
    )
    diffuse: float = number(0.35, low=0, high=10, doc="scale of the diffuse term; 0: none")
    width: float = number(
        0.0,
        low=0,
        unit="m",
        doc="strand diameter near the root; in a z-buffer at least one pixel; 0: lines one pixel wide",
    )
    rounded: bool = boolean(True, doc="resolve light across strands wider than two pixels; false: use its average")
    taper: float | None = number(
        None,
        low=0,
        high=1,
        doc="fraction of the width lost from root to tip; absent: 0.7, or 0 for widths of a file",
    )
    opacity: float = number(
        1.0, low=0, high=1, doc="fraction of the light behind that a strand blocks where it covers (sorted)"
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
        "redundant points",
    )
    level: int = integer(2, low=0, high=8, doc="pieces per segment: 2 ** level (fixed), or at most that (adaptive)")
    tolerance: float = number(
        0.25, above=0, unit="px",
        doc="greatest error of a piece (adaptive) or of a removed point (thinned)",
    )  # fmt: skip
    tangents: str = choice(
        "difference",
        ("difference", "printed"),
        doc="difference: central differences; printed: the thesis' cross products, with their artefact",
    )


@dataclass(frozen=True, slots=True, repr=False)
class Detail:
    """Level of detail: of strands far away the fraction near / distance is drawn, wider by its inverse."""

    near: float | None = number(
        None,
        above=0,
        unit="m",
        doc="distance up to which all strands are drawn; absent: where they are at least `pixels` wide",
    )
    pixels: float = number(
        1.0,
        above=0,
        high=100,
        unit="px",
        doc="width of a root on screen, in samples, below which fewer strands are drawn; without near",
    )
    fraction: float = number(0.1, above=0, high=1, doc="least fraction of strands that is drawn")
    widen: bool = boolean(True, doc="widen strands by 1 / fraction, so that coverage stays")
