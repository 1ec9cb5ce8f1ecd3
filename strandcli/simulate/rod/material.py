"""Material of rods: density, radius and Young's modulus, and the masses and rigidities that follow."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...errors import UsageError
from ...groom.record import Groom
from ...scene.model import Rod, Scene

MATERIALS = {
    # density kg/m³, radius m, Young's modulus Pa. Hair: Robbins 2012, ch. 8-9; grass: a ryegrass blade as a round
    # stalk, Vincent 1991
    "hair": (1320.0, 3.5e-5, 4.0e9),
    "grass": (700.0, 6.0e-4, 5.0e8),
}
STIFFEST = 1e30
"""Upper bound of a joint's rigidity, 1/s²: beyond it no step of time shows a bend."""

TORSION = {False: 4.0, True: 0.75}
"""Torsional over bending rigidity; True: of grooms with coils. Nothing else of straight strands resists twist."""
CELLS_ACROSS = 32
"""Cells of the rule interaction along the groom's greatest extent, where the preset gives no cell."""
MOST_SAMPLES = 64
"""Samples of a segment, no more than a cell apart."""


def matter(rod: Rod) -> tuple[float, float, float]:
    """Return density, radius at the root and Young's modulus: those of the named material unless given."""
    return tuple(  # type: ignore[return-value]
        own if given is None else given
        for given, own in zip((rod.density, rod.radius, rod.young), MATERIALS[rod.material], strict=True)
    )


MARGIN = 0.5
"""Thicknesses beyond that of the rule contact at which pairs are looked at: a round of forces may bring them nearer."""


def contact_thickness(scene: Scene, groom: Groom, given: float | None) -> float:
    """Return the distance that the middles of strands keep by the rule contact, metres. Raises `UsageError` for one
    that does not fit the groom."""
    own = 2 * matter(scene.rod)[1]
    found = given or own
    if found > (spread := _spread(groom)):
        raise UsageError(
            f"{scene.label or scene.source or 'scene'}: rule contact.thickness: {found:g} m is more than the groom, "
            f"which is {spread:.3g} m wide; make it smaller, such as {own:.2g}, the strands' own"
        )
    return found


def _spread(groom: Groom) -> float:
    """Return how wide a groom may come to be, metres."""
    return float(np.linalg.norm(np.ptp(groom.roots, axis=0))) + 2 * float(groom.lengths.max())


def cell_of(scene: Scene, groom: Groom, given: float | None, extent: float, most: str = "") -> float:
    """Return the side of cells of the rule interaction, metres. Raises `UsageError` for one that strands cannot fill.

    ``given``: by the preset; ``extent``: of the strands, metres, at ``most`` where that is not known."""
    thick, longest = 2 * matter(scene.rod)[1], float(groom.lengths.max()) / (scene.emitter.particles - 1)
    usual = max(extent / CELLS_ACROSS, longest / MOST_SAMPLES)
    if given is None:
        return usual
    where = f"{scene.label or scene.source or 'scene'}: rule interaction.cell: {given:g} m is"
    if given < thick:
        raise UsageError(f"{where} less than a strand's thickness of {thick:.3g} m; take {usual:.2g}")
    if given < longest / MOST_SAMPLES * (1 - 1e-6):
        raise UsageError(
            f"{where} less than a {MOST_SAMPLES}th of a segment of {longest:.3g} m; take {usual:.2g}, or more "
            "emitter.particles"
        )
    if given > extent:
        raise UsageError(f"{where} larger than the groom, which is {most}{extent:.3g} m wide; take {usual:.2g}")
    return float(given)


def require_between(scene: Scene, groom: Groom) -> None:
    """Raise `UsageError` for what rods refuse, before they begin, of the rules contact and interaction."""
    for use in scene.rules if scene.solver == "rod" else ():
        if use.name == "contact":
            contact_thickness(scene, groom, use.parameters.thickness)
        elif use.name == "interaction":
            cell_of(scene, groom, use.parameters.cell, _spread(groom), "at most ")


def rigidity(rod: Rod) -> float:
    """Return B / (ρ A) = E R² / (4 ρ) of a rod at its root, m⁴/s². The ratio Γ of g L³ to it determines how a strand
    sags."""
    density, radius, young = matter(rod)
    return young * radius**2 / (4 * density)


def torsion(rod: Rod, coiled: bool) -> float:
    """Return torsional over bending rigidity."""
    return TORSION[coiled] if rod.torsion is None else rod.torsion


def stiffness(rod: Rod, lengths: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (strands,) B / (ρ A ℓ⁴), 1/s², the rigidity of a joint at the root, for segment lengths in metres."""
    return np.asarray(np.minimum(rigidity(rod) / lengths**4, STIFFEST))


def segments_along(rod: Rod, n: int) -> NDArray[np.float64]:
    """Return (n,) masses of segments, relative to one at the root."""
    radius = 1 + (rod.tip - 1) * np.arange(n + 1) / n
    return np.asarray(((radius[:-1] + radius[1:]) / 2) ** 2)


def matter_along(rod: Rod, n: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return masses of particles and rigidities of joints, (n,) each, relative to a segment at the root; half a mass at
    the tip and twice the rigidity at the root make the discretisation second order."""
    radius = 1 + (rod.tip - 1) * np.arange(n + 1) / n
    segments = segments_along(rod, n)
    mass = np.append((segments[:-1] + segments[1:]) / 2, segments[-1] / 2)
    joint = radius[:-1] ** 4
    joint[0] *= 2
    return mass, joint
