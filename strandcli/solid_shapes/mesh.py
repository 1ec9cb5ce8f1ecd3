"""A mesh of triangles from a file: closed, or open where its surface goes more than half around what is inside.

What it needs of NumPy and Numba stands in `strandcli.mesh_file`, imported when such a solid is drawn or touched.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..scene import fields
from ..scene.fields import choice, integer, items, number
from ..scene.model.placed import MeshKey, longest_side, placing, unit_scale, up_axis
from ..scene.model.solids import SolidSettings

kind = "mesh"
folds = True
LAZY = {
    "Data": "kernels.arrays", "data": "prepared", "triangles": "prepared", "distance": "kernels.shape",
    "normal": "kernels.shape", "meet": "kernels.shape", "meets": "kernels.shape", "hides": "kernels.shape",
    "look": "kernels.shape", "distances": "kernels.shape", "slopes": "kernels.shape", "bounds": "kernels.shape",
    "drift": "kernels.shape",
}  # fmt: skip
"""Parts of the shape that are imported when they are asked for, by the module of `strandcli.mesh_file`."""


@dataclass(frozen=True, slots=True, repr=False)
class Settings(SolidSettings):
    """Triangles of a file: a head, an animal. In its own frame they stand as in the file, times `scale`, with y up."""

    kind: str = choice("mesh", ("mesh",))
    file: str = fields.file("mesh", doc="mesh of triangles: .obj, .ply, .stl, .glb or .gltf")
    up: str = up_axis()
    scale: float | None = unit_scale()
    size: float | None = longest_side()
    place: str = placing()
    colour_from: str = choice(
        "auto",
        ("auto", "file", "colour"),
        doc="file: its texture or vertex colours; colour: `colour`; auto: the file's, unless `colour` is set",
    )
    texture: str | None = fields.file("picture", None, doc="texture; absent: the file's")
    deform: tuple[MeshKey, ...] = items(
        MeshKey,
        doc="meshes over time, linear in between; triangles, colours and placement are those of `file`",
    )
    crease: float = number(
        60.0, low=0, high=180, unit="deg",
        doc="angle between triangles from which their edge is drawn sharp; vertex normals of the file take precedence",
    )  # fmt: skip
    resolution: int = integer(
        128, low=16, high=512, doc="nodes along the longest side of the distance grid, for contact and soft shadows"
    )


def numbers(settings: Settings) -> tuple[float, ...]:
    """None: all is in the data."""
    return ()


def reach(settings: Settings) -> float:
    """Distance of the farthest vertex from the origin."""
    from ..mesh_file.prepared import reach_of

    return reach_of(settings)


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name not in LAZY:
        raise AttributeError(name)
    return getattr(import_module(f"strandcli.mesh_file.{LAZY[name]}"), name)
