"""What is turned, scaled and placed: files of solids, emitters and strands, meshes to grow on, poses over time.

The settings of a file are functions and no base class: slots of two bases do not go together, and solids have a base of
their own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..fields import Vector, choice, file, items, number, surface_map, text, vector

AXES = ("x", "y", "z", "-x", "-y", "-z")


def up_axis(auto: str = "") -> Any:
    """The up axis of a file; ``auto``: what is done where none is given, if not to take y."""
    doc = "up axis of the file, which becomes y"
    return choice("auto", ("auto", *AXES), doc=f"{doc}. auto: {auto}") if auto else choice("y", AXES, doc=doc)


def unit_scale(absent: str = "1") -> Any:
    """Metres a unit of the file."""
    return number(None, above=0, unit="1", doc=f"metres a unit of the file; absent: {absent}")


def longest_side(box: str = "its box") -> Any:
    """Longest side, in place of a scale."""
    return number(None, above=0, unit="m", doc=f"longest side of {box}, in place of `scale`; absent: by scale")


def placing(where: str = "it is", box: str = "its box") -> Any:
    """Where what the file holds is put."""
    return choice(
        "file",
        ("file", "origin", "ground"),
        doc=f"file: where {where} in the file; origin: the middle of {box} at the origin; ground: above it, the lowest "
        "point at y = 0",
    )


@dataclass(frozen=True, slots=True, repr=False)
class PoseKey:
    """A position and an orientation at one moment."""

    time: float = number(0.0, unit="s", doc="frame 1 is at 0")
    position: Vector = vector((0.0, 0.0, 0.0), unit="m", doc="translation")
    rotation: Vector = vector((0.0, 0.0, 0.0), unit="deg", doc="Euler angles about x, then y, then z; may exceed 360")
    ease: str = choice("smooth", ("smooth", "linear", "step"), doc="interpolation to the next key")


@dataclass(frozen=True, slots=True)
class MeshKey:
    """A shape of a mesh that deforms, at a time."""

    time: float = number(0.0, unit="s", doc="seconds")
    file: str = file("mesh", doc="mesh with the vertices of `file` in the same order")


@dataclass(frozen=True, slots=True, repr=False)
class MeshShape:
    """Roots spread by area, or by a density, over the triangles of a file, in the emitter's frame."""

    kind: str = choice("mesh", ("mesh",))
    file: str = file("mesh", doc="mesh of triangles: .obj, .ply, .stl, .glb or .gltf")
    up: str = up_axis()
    scale: float | None = unit_scale()
    size: float | None = longest_side()
    place: str = placing()
    deform: tuple[MeshKey, ...] = items(
        MeshKey,
        doc="meshes over time, linear in between; with the rule emitter_motion, roots and directions follow their "
        "triangles",
    )
    density: str = surface_map(doc="vertex attribute or picture: density of roots; absent: uniform")
    above: float | None = number(
        None, unit="m", doc="height above which strands grow, without a density; absent: everywhere"
    )
    length: str = surface_map(
        doc="vertex attribute or picture: factor of `emitter.length`, clamped to 0.02 ... 1; absent: 1"
    )
    colours: str = choice(
        "none",
        ("none", "file"),
        doc="file: the mesh's colour at each root, from its texture or its vertices; none: the material's",
    )
    comb: str = text(
        "",
        doc="vertex attribute of three numbers, or NAME_x, NAME_y, NAME_z: direction of combing in the file's "
        "axes; `emitter.comb` where it is 0",
    )
