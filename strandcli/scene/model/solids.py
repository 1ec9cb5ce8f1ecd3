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

    It may have `OPTIONAL` functions, `data` with its class ``Data``, `triangles`, ``folds`` and ``convex``, each of
    which makes it quicker or more accurate: docs/extending.md, "A shape of solid", has what each takes and gives.

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
