"""What meshes of solids take, and what is to be said of them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..common.counted import counted
from ..meshes.bvh import grid_nodes
from .prepared import box_of, mesh_of

PER_TRIANGLE = 360
"""Bytes of a triangle: corners, normals and faces, its part of the tree, and the mesh as it was read."""
PER_NODE = 4
"""Bytes of a node of the grid."""
FAR = 10.0
"""How many times larger or smaller than roots and strands together a mesh is taken to be in another unit."""


def nodes(settings: Any) -> tuple[int, int, int]:
    """Nodes of the grid of distances along x, y and z, as `make_distance_grid` has them."""
    x, y, z = grid_nodes(*box_of(settings), settings.resolution)[0].tolist()
    return x, y, z


def grid_bytes(settings: Any) -> int:
    """Bytes of the grid of distances."""
    x, y, z = nodes(settings)
    return x * y * z * PER_NODE


def whole_bytes(settings: Any) -> int:
    """Bytes of all that is made of a mesh."""
    mesh = mesh_of(settings)
    picture = 0 if mesh.texture is None else 4 * mesh.texture.size // 3 + mesh.texture.size
    # while it is made, the grid is there twice
    return PER_TRIANGLE * len(mesh.triangles) + 2 * grid_bytes(settings) + picture


def described(settings: Any) -> str:
    """A mesh and its grid, in words."""
    mesh = mesh_of(settings)
    x, y, z = nodes(settings)
    inside = "" if mesh.closed else ", open"
    return (
        f"{counted(len(mesh.triangles), 'triangle')}{inside}; a grid of {x} × {y} × {z} distances, "
        f"{grid_bytes(settings) / 1e6:.1f} MB, for contact and soft shadows"
    )


def warnings(name: str, settings: Any, extent: float, touched: bool) -> Iterator[str]:
    """What is to be said of a solid that is a mesh. ``extent``: of roots and strands together, metres; ``touched``:
    whether strands collide with it."""
    mesh = mesh_of(settings)
    large = mesh.size() / extent
    if not 1 / FAR <= large <= FAR:
        times = f"{large:.3g} times larger" if large > 1 else f"{1 / large:.3g} times smaller"
        yield (
            f"{name}: is {mesh.size():.3g} m large, {times} than roots and strands together: perhaps its file has "
            f"another unit; set its scale, or its size in metres, and emitter.length to match"
        )
    if settings.texture and settings.colour_from == "colour":
        yield (
            f"{name}: colour_from: colour leaves out its texture {Path(settings.texture).name}; set colour_from to "
            "auto, or texture to null"
        )
    elif settings.texture and mesh.uv is None:
        yield (
            f"{name}: has no texture coordinates, by which its texture {Path(settings.texture).name} would lie on it, "
            "and is drawn without; take a mesh with uv, or set its colour"
        )
    elif settings.colour_from == "file" and not settings.texture and mesh.texture is None and mesh.colours is None:
        yield f"{name}: its file has neither vertex colours nor a texture, which colour_from: file asks for"
    facts = mesh.facts
    if touched and facts.boundary:
        yield (
            f"{name}: is open, {facts.boundary:,} edges belong to one triangle alone: inside, where strands must not "
            "be, is where its surface goes more than half around; close it in its program if that is not meant"
        )
    doubtful = facts.twisted + facts.crowded
    if touched and doubtful:
        yield (
            f"{name}: at {counted(doubtful, 'edge')} its triangles do not agree on an outside, so that contact is "
            "doubtful there; mend the mesh in its program"
        )
