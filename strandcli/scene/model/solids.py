"""Things beside the strands."""

# ruff: noqa: RUF009 - these calls make dataclass fields

from __future__ import annotations

from dataclasses import dataclass

from ..fields import Colour, Vector, boolean, choice, colour, items, number, text, vector
from .pose import PoseKey


@dataclass(frozen=True, slots=True, repr=False)
class SolidSettings:
    """What all solids have; `kind` tells them apart."""

    kind: str = ""
    name: str = text("", doc="name for a collision rule's `with`")
    position: Vector = vector((0.0, 0.0, 0.0), unit="m", doc="centre")
    rotation: Vector = vector((0.0, 0.0, 0.0), unit="deg", doc="Euler angles about x, then y, then z")
    keys: tuple[PoseKey, ...] = items(PoseKey, doc="motion, in place of position and rotation")
    follow: str = choice("none", ("none", "emitter"), doc="emitter: the pose is taken in the emitter's frame")
    colour: Colour = colour((0.18, 0.18, 0.18), doc="diffuse colour")
    coat: float = number(
        0.0, low=0, high=1, doc="share of light that a coat mirrors straight on, .04 is varnish or wax; 0: matte"
    )
    roughness: float = number(0.3, low=0.05, high=1, doc="of the coat; 0.1 is polished, 0.5 satin")
    mottle: float = number(0.0, low=0, high=1, doc="spread of brightness from patch to patch")
    grain: float = number(0.1, above=0, unit="m", doc="width of the largest patches")
    visible: bool = boolean(True, doc="drawn, and casting shadows; collisions do not ask")


@dataclass(frozen=True, slots=True, repr=False)
class _RoundSolid(SolidSettings):
    """What runs into others of its kind, if wanted."""

    blend: float = number(
        0.0,
        low=0,
        unit="m",
        doc="way over which it runs into other spheres and capsules that blend; all of them are drawn as the first",
    )


@dataclass(frozen=True, slots=True, repr=False)
class SphereSolid(_RoundSolid):
    """A ball."""

    kind: str = choice("sphere", ("sphere",))
    radius: float = number(1.0, above=0, unit="m", doc="radius")


@dataclass(frozen=True, slots=True, repr=False)
class CapsuleSolid(_RoundSolid):
    """A rounded cylinder along its own y axis."""

    kind: str = choice("capsule", ("capsule",))
    radius: float = number(1.0, above=0, unit="m", doc="radius")
    length: float = number(1.0, low=0, unit="m", doc="distance between the centres of its two round ends")


@dataclass(frozen=True, slots=True, repr=False)
class PlaneSolid(SolidSettings):
    """Everything below a plane through `position`, whose normal is its own +y axis: a ground."""

    kind: str = choice("plane", ("plane",))
    position: Vector = vector((0.0, 0.0, 0.0), unit="m", doc="a point of the plane")
    fade: float = number(
        0.0, low=0, unit="m", doc="distance from `position` over which it fades into the background; 0: never"
    )


@dataclass(frozen=True, slots=True, repr=False)
class BoxSolid(SolidSettings):
    """A cuboid."""

    kind: str = choice("box", ("box",))
    size: Vector = vector((1.0, 1.0, 1.0), above=0, unit="m", doc="whole extents along its own axes")


Solid = SphereSolid | CapsuleSolid | PlaneSolid | BoxSolid
SOLIDS: dict[str, type] = {"sphere": SphereSolid, "capsule": CapsuleSolid, "plane": PlaneSolid, "box": BoxSolid}
"""The settings of each kind; those of other packages are added by `strandcli.scene.solid_shape`."""
