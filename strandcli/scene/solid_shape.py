"""Shapes of solids from other packages: what the scene has to be told in order to read them from a preset."""

from __future__ import annotations

from typing import Any, Protocol

from ..errors import UsageError
from ..registry import load, offered
from .model.solids import SOLIDS, SolidSettings

_shapes: dict[str, SolidShape] = {}
GROUP = "strandcli.solids"


class SolidShape(Protocol):
    """A shape of solid that is not one of strandcli's own: any object or module with these names.

    ``kind`` is what presets write. ``Settings`` is a frozen dataclass that inherits from `SolidSettings`, whose fields
    are made with the helpers of `fields.py`; its own ``kind`` is ``choice(kind, (kind,))``. Of such settings
    ``numbers`` gives the numbers that ``distance`` takes, always as many, and ``reach`` the radius, metres, of a ball
    about the solid's own origin that holds all of it.

    ``distance(x, y, z, numbers)`` is the distance of a point of the solid's own frame from the surface, metres,
    negative inside: never more than to the nearest point of the surface, and 1 per metre steep at the most. It is a
    plain function of a module that can be imported, compiled by strandcli: arithmetic, `math` and functions that Numba
    has compiled.
    """

    kind: str
    Settings: type

    def numbers(self, settings: Any) -> tuple[float, ...]: ...
    def reach(self, settings: Any) -> float: ...
    def distance(self, x: Any, y: Any, z: Any, numbers: Any) -> Any: ...


def add(shape: SolidShape) -> None:
    """Let presets have solids of a shape. Raises `UsageError` where it lacks a part or its kind is taken."""
    name = getattr(shape, "kind", shape)
    for part in ("kind", "Settings", "numbers", "reach", "distance"):
        if not hasattr(shape, part):
            raise UsageError(f"solid {name!r}: has no `{part}` (see strandcli.solids.register)")
    if not issubclass(shape.Settings, SolidSettings):
        raise UsageError(f"solid {name!r}: its Settings must inherit from strandcli.scene.model.SolidSettings")
    if shape.kind in SOLIDS and _shapes.get(shape.kind) is not shape:
        raise UsageError(f"solid {name!r}: another shape has this kind")
    _shapes[shape.kind] = shape
    SOLIDS[shape.kind] = shape.Settings


def shape_of(kind: str) -> SolidShape:
    """The shape of a kind that has been added."""
    return _shapes[kind]


def search() -> None:
    """Add the shapes that installed packages name under ``strandcli.solids``. Raises `UsageError`."""
    for entry in offered(GROUP):
        add(load(entry, "solid"))
