"""What strands absorb: from melanin, from a kind of hair by name, or from the colour that a mass of them has.

Absorption σ_a is in 1/radius. Melanin: d'Eon, Francois, Hill, Letteri & Aubry (2011, "An Energy-Conserving Hair
Reflectance Model"), σ_a a unit of concentration. Colours: the fit of Chiang et al. (2016, eq. 9) between the colour of
a mass of strands, with all light that goes from strand to strand, and the absorption of one of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from ...scene.model import Material

DARKEST, PALEST = 1e-4, 1.0
EUMELANIN = np.array([0.419, 0.697, 1.37])
PHEOMELANIN = np.array([0.187, 0.4, 1.05])

CONCENTRATIONS: dict[str, tuple[float, float]] = {
    "black": (6.0, 0.0),
    "dark_brown": (2.2, 0.1),
    "brown": (1.0, 0.15),
    "light_brown": (0.45, 0.15),
    "auburn": (0.5, 0.8),
    "red": (0.1, 0.8),
    "dark_blond": (0.2, 0.1),
    "blond": (0.08, 0.08),
    "platinum": (0.02, 0.02),
    "white": (0.002, 0.002),
}
"""Eumelanin and pheomelanin of kinds of hair, chosen by eye: rendered masses look as their names say."""


def absorption(colour: ArrayLike, roughness: float) -> NDArray[np.float64]:
    """σ_a of strands whose mass has this ``colour`` (any shape, linear); ``roughness`` is Chiang's β_n.

    Colours are clamped to [1e-4, 1]: black would be infinitely absorbing, and nothing is whiter than σ_a = 0.
    """
    clamped = np.clip(np.asarray(colour, np.float64), DARKEST, PALEST)
    return np.asarray((np.log(clamped) / _divisor(roughness)) ** 2)


def mass_colour(sigma: ArrayLike, roughness: float) -> NDArray[np.float64]:
    """The inverse of `absorption`: the linear colour of a mass of strands that absorb ``sigma``."""
    return np.asarray(np.exp(-_divisor(roughness) * np.sqrt(np.asarray(sigma, np.float64))))


def _divisor(b: float) -> float:
    return 5.969 - 0.215 * b + 2.532 * b**2 - 10.73 * b**3 + 5.574 * b**4 + 0.245 * b**5


def has_melanin(material: Material) -> bool:
    """Whether a material's colour comes from melanin and not from ``material.colour``."""
    return material.pigment != "rgb" or material.eumelanin is not None or material.pheomelanin is not None


def absorption_of(material: Material, roughness: float) -> NDArray[np.float64]:
    """(3,) σ_a at the root of a strand of middle tone. A concentration that is written replaces that of the kind."""
    if not has_melanin(material):
        return absorption(material.colour, roughness)
    eumelanin, pheomelanin = CONCENTRATIONS.get(material.pigment, (0.0, 0.0))
    if material.eumelanin is not None:
        eumelanin = material.eumelanin
    if material.pheomelanin is not None:
        pheomelanin = material.pheomelanin
    return eumelanin * EUMELANIN + pheomelanin * PHEOMELANIN


def colour_of(material: Material, roughness: float) -> NDArray[np.float64]:
    """(3,) linear colour of a mass of strands of middle tone, at the root."""
    if not has_melanin(material):
        return np.array(material.colour, np.float64)
    return mass_colour(absorption_of(material, roughness), roughness)


def varies(material: Material) -> bool:
    """Whether any two places on any strands differ in colour."""
    return material.tip_colour is not None or material.colour_variation > 0 or material.grey > 0


def tint(
    material: Material, roughness: float, along: NDArray[np.float64], tone: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Colour of a mass and σ_a, (…, 3) each, at places ``along`` a strand, [0, 1], of strands of ``tone`` in [−1, 1].

    An RGB colour is multiplied by (1 + variation)^tone, so that none turns negative and dark and pale strands are as
    frequent; melanin is divided by it. The share ``material.grey`` of strands, those of the palest tone, have none, but
    the colour ``material.grey_colour``.
    """
    spread = np.log1p(material.colour_variation) * tone[..., None]
    along = along[..., None]
    if has_melanin(material):
        root = absorption_of(material, roughness) * np.exp(-spread)
        tip = root if material.tip_colour is None else absorption(material.tip_colour, roughness) * np.exp(-spread)
        # between root and tip the logarithm of the colour is linear, which the root of the absorption is
        sigma = (np.sqrt(root) + along * (np.sqrt(tip) - np.sqrt(root))) ** 2
        colour = mass_colour(sigma, roughness)
    else:
        first = np.array(material.colour)
        last = first if material.tip_colour is None else np.array(material.tip_colour)
        colour = (first + along * (last - first)) * np.exp(spread)
        sigma = absorption(colour, roughness)
    faded = (tone > 1.0 - 2.0 * material.grey)[..., None]
    other = np.array(material.grey_colour, np.float64)
    return np.where(faded, other, colour), np.where(faded, absorption(other, roughness), sigma)
