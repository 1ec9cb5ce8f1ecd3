"""Meshes that strands grow on."""

from __future__ import annotations

from dataclasses import dataclass

from ..fields import choice, file, items, number, surface_map, text
from . import placed_file


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
    up: str = placed_file.up()
    scale: float | None = placed_file.scale()
    size: float | None = placed_file.size()
    place: str = placed_file.place()
    deform: tuple[MeshKey, ...] = items(
        MeshKey,
        doc="meshes over time, linear in between; with the rule emitter_motion, roots and directions follow their "
        "triangles",
    )
    density: str = surface_map(doc="vertex attribute or picture: density of roots; absent: uniform")
    above: float | None = number(
        None,
        unit="m",
        doc="height above which strands grow, without a density; absent: everywhere",
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
