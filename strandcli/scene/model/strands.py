"""What strands are made of and look like: matter, light, children, smoothness, and how many are drawn."""

# ruff: noqa: RUF009 - these calls make dataclass fields

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ...common.registry import FIBRES
from .. import fields
from ..fields import Colour, boolean, choice, colour, integer, items, number, parameters

PIGMENTS = (
    "rgb", "black", "dark_brown", "brown", "light_brown", "auburn", "red", "dark_blond", "blond", "platinum", "white",
)  # fmt: skip


TAPER = 0.7
"""Part of the width that strands lose from root to tip where neither a preset nor a file says so."""
PER_WAVE = 6
"""Pieces that a wave is drawn with, at least."""
MOST_STEPS = 16


@dataclass(frozen=True, slots=True, repr=False)
class Material:
    """How strands scatter light: by Marschner et al. 2003 or Chiang et al. 2016, and light between strands."""

    model: str = choice(
        "marschner", FIBRES, doc="marschner uses alpha, beta, azimuthal; chiang uses tilt, beta_m, beta_n"
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
        None, low=0, high=1, doc="fraction of the width lost from root to tip; absent: 0.7, or 0 for widths of a file"
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


@dataclass(frozen=True, slots=True, repr=False)
class Clump:
    """Clumps (locks): strands are drawn toward the strand at the clump's centre, the more the nearer to the tip."""

    size: float = number(0.02, above=0, unit="m", doc="distance between clump centres at the roots")
    strength: float = number(
        0.7,
        low=0,
        high=1,
        doc="fraction of the distance to the clump centre by which tips are moved; 1: pointed clumps",
    )
    shape: float = number(1.0, above=0, high=10, doc="exponent along the strand: 0.5 clumps early, 3 late")
    variation: float = number(0.4, low=0, high=1, doc="variation of the strength between clumps")
    stray: float = number(0.05, low=0, high=1, doc="fraction of strands outside any clump")


@dataclass(frozen=True, slots=True, repr=False)
class Wave:
    """Waves, curls or frizz, with the length of strands preserved, so that tips draw up."""

    radius: float = number(0.003, low=0, unit="m", doc="amplitude")
    length: float = number(0.04, above=0, unit="m", doc="wavelength along the strand")
    round: float = number(0.4, low=0, high=1, doc="0: flat waves, 1: helices")
    onset: float = number(0.3, low=0, high=1, doc="fraction of a strand over which waves grow to full amplitude")
    disorder: float = number(0.1, low=0, high=1, doc="0: the strands of a clump in phase; 1: each by itself, frizz")
    share: float = number(1.0, low=0, high=1, doc="fraction of the strands that wave; 0.02: stray hairs")


@dataclass(frozen=True, slots=True, repr=False)
class Children:
    """Strands drawn around the simulated ones. Each follows its three nearest guides; then come clumps, waves, its own
    length, and the solids of a collision rule."""

    count: int = integer(10, low=1, high=10_000, doc="strands drawn per simulated strand")
    cut: float = number(0.0, low=0, high=1, doc="lengths are uniform in 1 - cut ... 1 times the guides'")
    undercoat: float = number(0.0, low=0, high=1, doc="fraction of strands that are short")
    undercoat_length: float = number(0.5, above=0, high=1, doc="length of the undercoat relative to the others'")
    clumps: tuple[Clump, ...] = items(Clump, doc="clumps and clumps in clumps, from wide to narrow")
    waves: tuple[Wave, ...] = items(Wave, doc="waves, curls and frizz, added up")

    def steps(self, segment: float) -> int:
        """In how many steps a guide's segment of so many metres is drawn, for the waves' sake."""
        seen = (wave.length for wave in self.waves if wave.radius > 0 and wave.share > 0)
        shortest = min(seen, default=math.inf)
        return min(max(math.ceil(PER_WAVE * segment / shortest), 1), MOST_STEPS)


@dataclass(frozen=True, slots=True, repr=False)
class Rod:
    """Material and settings of `solver: rod`. A named material gives density, radius and Young's modulus; a number
    written beside it replaces its own. Only strands with a curved rest shape twist."""

    material: str = choice("hair", ("hair", "grass"), doc="hair: a keratin fibre; grass: a blade")
    density: float | None = number(None, above=0, unit="kg/m³", doc="mass per volume; absent: the material's")
    radius: float | None = number(None, above=0, unit="m", doc="radius at the root; absent: the material's")
    young: float | None = number(None, above=0, high=1e13, unit="Pa", doc="Young's modulus; absent: the material's")
    tip: float = number(1.0, low=0.05, high=1, doc="radius at the tip over that at the root")
    rest: str = choice(
        "shape",
        ("straight", "shape", "sag_free"),
        doc="unbent shape. shape: as emitted, with curls; sag_free: such that the emitted shape hangs still under "
        "gravity, strands being stiffened where too soft",
    )
    root: str = choice(
        "clamped", ("clamped", "hinged"), doc="clamped: keeps the emitted direction; hinged: turns freely"
    )
    end: str = choice(
        "free",
        ("free", "pinned"),
        doc="the tip. pinned: stays where it is emitted, in the emitter's frame, and turns freely",
    )
    torsion: float | None = number(
        None, above=0, high=10,
        doc="torsional over bending rigidity of curled strands; a round fibre has 1 / (1 + Poisson's ratio), "
        "about 0.7; absent: 4, for coils 0.75",
    )  # fmt: skip
    drag: float = number(1.0, low=0, high=1e6, unit="1/s", doc="rate at which strands take on the air's velocity")
    damping: float = number(
        0.001, low=0, high=1e3, unit="s", doc="internal damping: bending moment per rate of bending"
    )
    friction: float = number(0.3, low=0, high=10, doc="Coulomb's coefficient against solids")
    iterations: int = integer(200, low=1, high=1000, doc="Newton iterations per step, at most; two are usual")
