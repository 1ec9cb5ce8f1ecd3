"""The strands' matter."""

from __future__ import annotations

from dataclasses import dataclass

from ..fields import choice, integer, number


@dataclass(frozen=True, slots=True, repr=False)
class Rod:
    """The strands' matter and how the solver `rod` moves them. Strands whose rest shape is curved twist; others do not.

    A material by name gives density, radius and Young's modulus; a number written beside it replaces its own.
    """

    material: str = choice("hair", ("hair", "grass"), doc="hair: a keratin fibre; grass: a blade")
    density: float | None = number(None, above=0, unit="kg/m³", doc="mass a volume; absent: the material's")
    radius: float | None = number(None, above=0, unit="m", doc="radius at the root; absent: the material's")
    young: float | None = number(None, above=0, high=1e13, unit="Pa", doc="Young's modulus; absent: the material's")
    tip: float = number(1.0, low=0.05, high=1, doc="radius at the tip over that at the root")
    rest: str = choice(
        "shape",
        ("straight", "shape", "sag_free"),
        doc="unbent form: straight; as emitted, curls included; or such that the emitted form hangs still "
        "under gravity, for which strands that are too soft are made stiffer",
    )
    root: str = choice(
        "clamped",
        ("clamped", "hinged"),
        doc="clamped: along the direction of emission; hinged: turns freely about its place",
    )
    end: str = choice(
        "free",
        ("free", "pinned"),
        doc="of the tip: free; or pinned where it is emitted, as the emitter carries it, about which it turns freely",
    )
    torsion: float | None = number(
        None, above=0, high=10,
        doc="torsional over bending rigidity of curled strands as round ones, 1 / (1 + Poisson's ratio), about 0.7: "
        "coils are springs; steps become shorter where that takes it; absent: 4, of coils 0.75",
    )  # fmt: skip
    drag: float = number(1.0, low=0, high=1e6, unit="1/s", doc="rate at which strands take on the velocity of the air")
    damping: float = number(0.001, low=0, high=1e3, unit="s", doc="inner damping: bending moment a rate of bending")
    friction: float = number(0.3, low=0, high=10, doc="Coulomb's coefficient against solids")
    iterations: int = integer(200, low=1, high=1000, doc="Newton iterations a step at the most; two are usual")
