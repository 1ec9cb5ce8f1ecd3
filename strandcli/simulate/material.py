"""Material of rods: density, radius and Young's modulus, and the masses and rigidities that follow."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..scene.model import Rod

MATERIALS = {
    # density kg/m³, radius m, Young's modulus Pa. Hair: Robbins 2012, ch. 8-9; wool: Feughelman 1997; grass: a ryegrass
    # blade as a round stalk, Vincent 1991; wire: spring steel of half a millimetre.
    "hair": (1320.0, 3.5e-5, 4.0e9),
    "wool": (1310.0, 1.2e-5, 3.0e9),
    "grass": (700.0, 6.0e-4, 5.0e8),
    "wire": (7850.0, 2.5e-4, 2.0e11),
}
STIFFEST = 1e30
"""Rigidity of a joint in 1/s² beyond which no step of time sees a strand bend; single precision ends soon after."""

TORSION = {False: 4.0, True: 0.25}
"""Torsional over bending rigidity, of grooms with coils where True; a round rod's is about 0.75. Nothing else resists
twist, so straight strands get more; for coils it limits the step, so they get less."""
CONTRAST = 1e5
"""Ratio of the stiffest joint to the softest above which single precision is not enough: rounding errors of the one are
a load to the other. Reached by a tip some twenty times as thick as the root."""
THROW = 1e6
"""Segments that a free strand would fall in a step above which single precision is not enough: tension is that many
times the inertia, and leaves it too few digits."""
STEADIEST = 20
"""Segments up to which single precision holds a sag-free strand still to 1e-6 of its length. Rounding of the moments in
its joints moves longer ones more: by 1e-5 with 1,000 segments."""


def matter(rod: Rod) -> tuple[float, float, float]:
    """Density, radius at the root and Young's modulus: those of the named material, where none are given."""
    return tuple(  # type: ignore[return-value]
        own if given is None else given
        for given, own in zip((rod.density, rod.radius, rod.young), MATERIALS[rod.material], strict=True)
    )


def rigidity(rod: Rod) -> float:
    """B / (ρ A) = E R² / (4 ρ) of a round rod at its root, in m⁴/s²: with g L³ over it, the number Γ that alone decides
    how a strand sags."""
    density, radius, young = matter(rod)
    return young * radius**2 / (4 * density)


def stiffness(rod: Rod, lengths: NDArray[np.float64]) -> NDArray[np.float64]:
    """(strands,) B / (ρ A ℓ⁴) in 1/s², the rigidity of a joint at the root, for segments of these lengths in m."""
    return np.asarray(np.minimum(rigidity(rod) / lengths**4, STIFFEST))


def matter_along(rod: Rod, n: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Masses of particles and rigidities of joints, (n,) each, relative to a segment at the root; half a mass at the
    tip and twice the rigidity at the root make the discretisation second order."""
    radius = 1 + (rod.tip - 1) * np.arange(n + 1) / n
    segments = ((radius[:-1] + radius[1:]) / 2) ** 2
    mass = np.append((segments[:-1] + segments[1:]) / 2, segments[-1] / 2)
    joint = radius[:-1] ** 4
    joint[0] *= 2
    return mass, joint


def needs_double(rod: Rod, joint: NDArray[np.float64], lengths: NDArray[np.float64], fall: float) -> bool:
    """Whether single precision is not enough for joints of these relative rigidities and segments of these lengths in
    m, which would fall so far, in m, in a step."""
    return (
        float(joint.max()) > CONTRAST * float(joint.min()) or fall > THROW * float(lengths.min())
        or (rod.rest == "sag_free" and len(joint) > STEADIEST)
    )  # fmt: skip
