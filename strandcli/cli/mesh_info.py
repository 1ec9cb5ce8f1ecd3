"""`strandcli info MESH`: how facts about a mesh are said, and its picture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import options
from .say import say

if TYPE_CHECKING:
    from ..meshes.mesh import TriangleMesh
    from ..scene.model import Scene

FILLED = 0.86
"""Share of the picture that the mesh fills."""


def say_facts(data: Mapping[str, Any]) -> None:
    """Facts for people: a line each."""
    box = data["box"]
    spans = [f"{'xyz'[i]} {box['min'][i]:.4g} to {box['max'][i]:.4g}" for i in range(3)]
    say(f"{data['file']}: {data['format']}, {data['bytes']:,} bytes")
    merged = f", {data['merged']:,} of the file at the place of another" if data["merged"] else ""
    say(f"  triangles  {data['triangles']:,}")
    say(f"  vertices   {data['vertices']:,}{merged}")
    say(f"  parts      {data['parts']:,}, {'closed' if data['closed'] else 'open'}")
    say(f"  box        {', '.join(spans)}")
    say(f"  area       {data['area']:.4g}")
    if data["volume"] is not None:
        say(f"  volume     {data['volume']:.4g}")
    if data["unit"] is not None:
        say(f"  unit       {data['unit']:.6g} m")
        say(f"  up         {data['up']}")
    for one in data["attributes"]:
        bounds = f", {one['min']:.4g} to {one['max']:.4g}" if one["domain"] != "pixel" else ""
        each = f"{one['shape'][1]} x {one['shape'][0]} pixels" if one["domain"] == "pixel" else f"each {one['domain']}"
        say(f"  attribute  {one['name']}: {one['type']} for {each}{bounds}")
    if data["guess"]["up"] is not None:
        say(f"  guess      up is {data['guess']['up']}")
    if data["guess"]["unit"] is not None:
        say(f"  guess      the unit is {data['guess']['unit']['unit']}")
    for one in data["faults"]:
        say(f"  fault      {one['text']}")
    for note in data["notes"]:
        say(f"  note       {note}")


def scene_of(path: Path, mesh: TriangleMesh, up: str) -> Scene:
    """A scene that shows a mesh as a solid in the light of the preset for strands of files, seen whole."""
    import strandcli

    from ..groom_file.measure import framed

    solid = {"kind": "mesh", "file": str(path.absolute()), "up": up, "size": 1.0, "place": "origin"}
    shown: dict[str, Any] = {
        "title": path.name, "emitter.groom": None, "emitter.strands": 1, "emitter.particles": 2,
        "emitter.length": 1e-6, "material.width": 1e-9, "detail": None, "camera.fit": None, "solids": [solid],
        "time.frames": 1, "time.fps": 24.0,
    }  # fmt: skip
    scene = strandcli.load(options.GROOM, settings=shown)
    low, high = mesh.box()
    from ..exchange.edit.transform import turning

    points = (mesh.vertices - 0.5 * (low + high)) @ turning(up, "y").T / mesh.size()
    return replace(scene, camera=framed(replace(scene.camera, fit=FILLED), points, scene.image.size))
