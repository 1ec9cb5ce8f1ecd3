"""Things beside the strands, and what the file of a shape of its own holds."""

# ruff: noqa: RUF009 - these calls make dataclass fields

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from ...common.registry import Registry
from ...errors import UsageError
from ..fields import Colour, Vector, boolean, choice, colour, items, number, text, vector
from .placed import PoseKey


@dataclass(frozen=True, slots=True, repr=False)
class SolidSettings:
    """What all solids have; `kind` tells them apart."""

    kind: str = ""
    name: str = text("", doc="name for a collision rule's `with`")
    position: Vector = vector((0.0, 0.0, 0.0), unit="m", doc="centre")
    rotation: Vector = vector((0.0, 0.0, 0.0), unit="deg", doc="Euler angles about x, then y, then z")
    keys: tuple[PoseKey, ...] = items(PoseKey, doc="motion; replaces position and rotation")
    follow: str = choice("none", ("none", "emitter"), doc="emitter: the pose is in the emitter's frame")
    colour: Colour = colour((0.18, 0.18, 0.18), doc="diffuse colour")
    coat: float = number(
        0.0, low=0, high=1, doc="reflectance of a coat at normal incidence: 0.04 varnish, 0.007 skin; 0: matte"
    )
    roughness: float = number(0.3, low=0.05, high=1, doc="roughness of the coat: 0.1 polished, 0.5 satin")
    mottle: float = number(0.0, low=0, high=1, doc="variation of brightness between patches")
    grain: float = number(0.1, above=0, unit="m", doc="width of the largest patches")
    subsurface: Vector = vector(
        (0.0, 0.0, 0.0),
        low=0,
        high=1,
        doc="spread of red, green and blue light under the surface; skin: about [0.4, 0.2, 0.12]; 0: opaque",
    )
    visible: bool = boolean(True, doc="draw it and its shadows; it stops strands either way")


@dataclass(frozen=True, slots=True, repr=False)
class SphereSolid(SolidSettings):
    """A ball."""

    kind: str = choice("sphere", ("sphere",))
    radius: float = number(1.0, above=0, unit="m", doc="radius")


@dataclass(frozen=True, slots=True, repr=False)
class CapsuleSolid(SolidSettings):
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
        0.0, low=0, unit="m", doc="distance from `position` over which the plane fades into the background; 0: never"
    )


@dataclass(frozen=True, slots=True, repr=False)
class BoxSolid(SolidSettings):
    """A cuboid."""

    kind: str = choice("box", ("box",))
    size: Vector = vector((1.0, 1.0, 1.0), above=0, unit="m", doc="whole extents along its own axes")


Solid = SphereSolid | CapsuleSolid | PlaneSolid | BoxSolid
BUILT_IN: dict[str, type] = {"sphere": SphereSolid, "capsule": CapsuleSolid, "plane": PlaneSolid, "box": BoxSolid}
"""The settings of the kinds that have kernels of their own."""


class _Shapes(Registry):
    """The shapes with a file of their own: the modules of `strandcli.solid_shapes`, and those of other packages."""

    def register(self, driver: Any) -> None:
        """As `Registry.register`. Raises `UsageError` also for settings that are not those of a solid."""
        kind = getattr(driver, "kind", driver)
        if not issubclass(getattr(driver, "Settings", SolidSettings), SolidSettings):
            raise UsageError(f"solid {kind!r}: its Settings must inherit from strandcli.scene.model.SolidSettings")
        if kind in BUILT_IN:
            raise UsageError(f"solid {kind!r}: another solid has this kind")
        super().register(driver)


SHAPES = _Shapes(
    "solid", "strandcli.solids", "solid_shapes", "", ("kind", "Settings", "numbers", "reach", "distance"), key="kind"
)
"""Shapes by their kind: `strandcli.scene.model.solids.SolidShape`."""


class _Kinds(Mapping[str, type]):
    """Settings by kind. A shape's file is imported when its kind is asked for."""

    def __getitem__(self, kind: str) -> type:
        if kind in BUILT_IN:
            return BUILT_IN[kind]
        found: type = SHAPES[kind].Settings
        return found

    def __iter__(self) -> Iterator[str]:
        yield from BUILT_IN
        yield from SHAPES.names()

    def __len__(self) -> int:
        return len(list(iter(self)))


SOLIDS: Mapping[str, type] = _Kinds()
"""The settings of every kind."""

OPTIONAL = ("meet", "meets", "normal", "hides", "look", "distances", "slopes", "bounds", "drift")
"""Compiled functions that a shape may have."""


class SolidShape(Protocol):
    """A shape of solid: a module of `strandcli.solid_shapes`, or any object or module of another package.

    ``kind`` is what presets write. ``Settings`` is a frozen dataclass that inherits from `SolidSettings`, whose fields
    are made with the helpers of `fields.py`; its own ``kind`` is ``choice(kind, (kind,))``. Of such settings
    ``numbers`` gives the numbers that the functions below take, always as many, and ``reach`` the radius, metres, of a
    ball about the solid's own origin that holds all of it.

    ``distance(x, y, z, numbers)`` is the distance of a point of the solid's own frame from the surface, metres,
    negative inside: never more than to the nearest point of the surface, and 1 per metre steep at the most.

    A shape may have more, each of which makes it quicker and more accurate:

    * ``meet(x, y, z, dx, dy, dz, numbers)``: where a ray that begins outside first meets the surface, as the multiple
      t ≥ 0 of d; `math.inf` where it does not. Else rays go forward by the distance, step by step.
    * ``meets(rays, found, numbers)``: the same of the rays of a pixel, as
      `strandcli.meshes.kernels.rays.first_hits` takes them. Else they are taken one by one.
    * ``normal(x, y, z, numbers)``: three numbers, not all 0, along the outward normal at the point of the surface that
      is nearest to a point, which may be on it, inside or outside. Else differences of the distance are taken.
    * ``hides(x, y, z, dx, dy, dz, reach, skin, numbers)``: whether it stands between a point and a light at ``reach``
      along the unit vector d. The point may be up to ``skin`` under the surface, which counts as on it. Else by
      `distance` until the ray is clear of the surface, and `meet`.
    * ``look(x, y, z, eye, width, before, numbers)``: how it is drawn at a point of its surface, as three triples: a
      vector along the normal, the point from which shadow rays set out, and the linear colour, which with a negative
      number is the solid's `colour`; and a whole number, which comes back as ``before`` with a point nearby, and may
      make it quicker to look at, but change nothing; at first it is -1. ``eye`` is the unit vector to the eye, or 0
      where that does not matter, ``width`` that of a pixel there, metres. Else `normal`, the point and `colour`.
    * ``distances(x, y, z, numbers)``: `distance` of vectors of `strandcli.simd`, which have no branches. Soft shadows
      look it up many times for each point. Else points are taken one by one.
    * ``slopes(x, y, z, numbers)``: `distances`, and as three more vectors their gradients, which may be 0 and need not
      be of length 1. Drawn strands that touch it are moved along its surface by them, many at once. Else one by one.
    * ``bounds(numbers)``: x, y, z of the low and of the high corner of a box in the solid's own frame, float32, whose
      distance from a point is never more than `distance`. Soft shadows look no further. Else they look through the
      ball.
    * ``folds = True``: it may hide parts of itself, and such edges are antialiased.
    * ``data(solids, time)``: what does not fit into a few numbers, for all solids of the kind (their settings, in a
      list) at a time in seconds: a NamedTuple of the class ``Data``, whose fields are contiguous arrays. It is asked
      for at every frame and step, and should return the same arrays until they change. The functions above then take
      it as one more argument, and the last of their ``numbers`` is the solid's place in the list.
    * ``drift(x, y, z, numbers)``: three numbers, how far the point of the surface nearest to a point came since the
      step before, in the solid's own frame, metres: what a shape that deforms carries along by friction. `data` of such
      a shape has a third parameter, ``past=None``, the time of the step before, which is given where strands move.
    * ``triangles(numbers, data)``: (T, 3, 3) float64, the corners of the triangles that are all of its surface, for a
      shape with data; not compiled. A pixel then looks at the triangles that may cover it. `meet` has to be the nearest
      of them, as `strandcli.meshes.kernels.rays.first_hit` gives it.
    * ``convex = True``: it is convex, and so is its distance along every line. The deepest place of a segment is then
      searched for; else segments are looked at in a few places.

    Functions are plain ones of a module that can be imported, compiled by strandcli: arithmetic, `math` and functions
    that Numba has compiled.
    """

    kind: str
    Settings: type

    def numbers(self, settings: Any) -> tuple[float, ...]: ...
    def reach(self, settings: Any) -> float: ...
    def distance(self, x: Any, y: Any, z: Any, numbers: Any) -> Any: ...


def has_data(shape: Any) -> bool:
    """Whether the functions of a shape read arrays besides its numbers."""
    return getattr(shape, "data", None) is not None


def add(shape: SolidShape) -> None:
    """Let presets have solids of a shape. Raises `UsageError` where it lacks a part or its kind is taken."""
    SHAPES.register(shape)


def shape_of(kind: str) -> SolidShape:
    """The shape of a kind that is not built in."""
    found: SolidShape = SHAPES[kind]
    return found
