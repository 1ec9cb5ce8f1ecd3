"""The strands' matter."""

from __future__ import annotations

from dataclasses import dataclass

from ..fields import choice, integer, number


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
        "clamped",
        ("clamped", "hinged"),
        doc="clamped: keeps the emitted direction; hinged: turns freely",
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
