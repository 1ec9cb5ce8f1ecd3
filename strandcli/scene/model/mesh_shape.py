"""Meshes that strands grow on."""

from __future__ import annotations

from dataclasses import dataclass

from ..fields import choice, file, items, number, surface_map, text
from . import placed_file


@dataclass(frozen=True, slots=True)
class MeshKey:
    """A shape of a mesh that deforms, at a time."""

    time: float = number(0.0, unit="s", doc="seconds")
    file: str = file("mesh", doc="mesh with the same vertices in the same order as `file` of what deforms")


@dataclass(frozen=True, slots=True, repr=False)
class MeshShape:
    """Roots spread evenly by area, or by a density, over the triangles of a file, which stand in the emitter's frame as
    a solid's of kind `mesh` do in its own."""

    kind: str = choice("mesh", ("mesh",))
    file: str = file("mesh", doc="mesh of triangles: .obj, .ply, .stl, .glb or .gltf")
    up: str = placed_file.up()
    scale: float | None = placed_file.scale()
    size: float | None = placed_file.size()
    place: str = placed_file.place()
    deform: tuple[MeshKey, ...] = items(
        MeshKey,
        doc="files between which its vertices move in straight lines; with the rule emitter_motion roots follow their "
        "triangles, and strands turn with them",
    )
    density: str = surface_map(
        doc="attribute of vertices or picture by which roots are spread; nothing grows where it is 0. Absent: evenly"
    )
    above: float | None = number(
        None,
        unit="m",
        doc="height above which strands grow, for a mesh without a density; the rim follows its triangles. Absent: all",
    )
    length: str = surface_map(
        doc="attribute of vertices or picture by which strands are shorter: a factor of `emitter.length` from 0 to 1, "
        "of which 0.02 is the least; absent: 1"
    )
    colours: str = choice(
        "none",
        ("none", "file"),
        doc="file: each strand has the mesh's colour at its root, that of the texture, else of the vertices; it varies "
        "by material.colour_variation, and toward the tip as material.colour does to tip_colour; none: the material's",
    )
    comb: str = text(
        "",
        doc="attribute of vertices, three numbers each or NAME_x, NAME_y and NAME_z: the direction of combing, in "
        "the file's axes; `emitter.comb` where it is 0",
    )
