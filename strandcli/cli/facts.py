"""What the commands for files of strands and of meshes share: options of reading, how facts are said, pictures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..common.counted import counted
from . import options
from .say import say

if TYPE_CHECKING:
    from ..meshes.mesh import TriangleMesh
    from ..scene.model import Scene

reading = options.together(
    click.option(
        "--stride", type=options.Whole(2, 1_000_000), metavar="N",
        help="Points a strand, where a file has vertices alone.",
    ),
    click.option("--array", metavar="NAME", help="Array of the points, where an .npz file has several."),
    options.objects,
)  # fmt: skip

MOST_OBJECTS = 20
"""Objects that are printed for people."""
FILLED = 0.86
"""Share of a picture that a mesh fills."""


def say_facts(data: Mapping[str, Any]) -> None:
    """Facts of strands or of a mesh for people: a line each."""
    kind = " ".join(part for part in (data["format"], data.get("version")) if part)
    say(f"{data['file']}: {kind}, {data['bytes']:,} bytes")
    for name, words in (*(_of_mesh(data) if "triangles" in data else _of_strands(data)), *_of_both(data)):
        say(f"  {name:<10} {words}")


def _of_mesh(data: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    merged = f", {data['merged']:,} of the file at the place of another" if data["merged"] else ""
    yield "triangles", f"{data['triangles']:,}"
    yield "vertices", f"{data['vertices']:,}{merged}"
    yield "parts", f"{data['parts']:,}, {'closed' if data['closed'] else 'open'}"
    yield "area", f"{data['area']:.4g}"
    if data["volume"] is not None:
        yield "volume", f"{data['volume']:.4g}"


def _of_strands(data: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    yield "strands", f"{data['strands']:,}"
    counts = data["points_a_strand"]
    if counts is not None:
        each = f"{counts['min']:,}" if counts["min"] == counts["max"] else f"{counts['min']:,} to {counts['max']:,}"
        yield "points", f"{data['points']:,}, {each} a strand"
    if (one := data["length"]) is not None:
        yield "length", f"{one['min']:.4g} to {one['max']:.4g}, median {one['median']:.4g}"


def _of_both(data: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    from ..exchange.objects import shown

    if (box := data["box"]) is not None:
        yield "box", ", ".join(f"{'xyz'[i]} {box['min'][i]:.4g} to {box['max'][i]:.4g}" for i in range(3))
    if data["unit"] is not None:
        yield "unit", f"{data['unit']:.6g} m"
    if data["up"] is not None:
        yield "up", data["up"]
    objects = data.get("objects", ())
    for one in objects[:MOST_OBJECTS]:
        yield "object", f"{shown(one['name'])}: {counted(one['strands'], 'strand')}, {one['points']:,} points"
    if len(objects) > MOST_OBJECTS:
        yield "object", f"and {len(objects) - MOST_OBJECTS:,} more, all of them with --json"
    for one in data["attributes"]:
        pixels = one["domain"] == "pixel"
        bounds = "" if pixels or one["min"] is None else f", {one['min']:.4g} to {one['max']:.4g}"
        each = f"{one['shape'][1]} x {one['shape'][0]} pixels" if pixels else f"each {one['domain']}"
        yield "attribute", f"{one['name']}: {one['type']} for {each}{bounds}"
    if data.get("moments") is not None:
        yield "moments", _moments(data["moments"])
    for name, value in data.get("header", {}).items():
        if value not in ("", None):
            yield "header", f"{name.replace('_', ' ')}: {value}"
    yield from (("guess", words) for words in _guesses(data["guess"]))
    if data.get("strands") and (words := _as_it_is(data)):
        yield "as it is", words
    for one in data["faults"]:
        yield "fault", one["text"] + (f"; convert {one['mend']}" if one.get("mend") else "")
    yield from (("note", words) for words in data.get("notes", ()))


def _moments(found: Mapping[str, Any]) -> str:
    """When strands are known."""
    if found["unit"] == "s":
        span = f"{found['first']:.4g} to {found['last']:.4g} s, {found['frames_a_second']:.4g} a second"
    else:
        span = f"files {found['first']:.0f} to {found['last']:.0f}"
        span += f", {found['missing']:,} of them missing" if found["missing"] else ""
    return f"{found['count']:,}, {span}"


def _guesses(guess: Mapping[str, Any]) -> Iterator[str]:
    if guess.get("root") is not None:
        yield f"roots are {guess['root']}"
    if guess["up"] is not None:
        yield f"up is {guess['up'] if isinstance(guess['up'], str) else guess['up']['axis']}"
    if guess.get("unit") is not None:
        yield f"the unit is {guess['unit']['unit']}"


def _as_it_is(data: Mapping[str, Any]) -> str:
    """What holds because neither the file nor its strands tell otherwise, "" where they tell all."""
    guess = data["guess"]
    taken = {"roots are first": (None, guess["root"]), "up is y": (data["up"], guess["up"]),
             "units are metres": (data["unit"], None)}  # fmt: skip
    found = ", ".join(words for words, known in taken.items() if known == (None, None))
    return found and f"{found}: there is no evidence for a guess"


def scene_of(path: Path, mesh: TriangleMesh, up: str) -> Scene:
    """A scene that shows a mesh as a solid in the light of the preset for strands of files, seen whole."""
    import strandcli

    from ..common.rotations import turning
    from ..groom_file.measure import framed

    solid = {"kind": "mesh", "file": str(path.absolute()), "up": up, "size": 1.0, "place": "origin"}
    shown: dict[str, Any] = {
        "title": path.name, "emitter.groom": None, "emitter.strands": 1, "emitter.particles": 2,
        "emitter.length": 1e-6, "material.width": 1e-9, "detail": None, "camera.fit": None, "solids": [solid],
        "time.frames": 1, "time.fps": 24.0,
    }  # fmt: skip
    scene = strandcli.load(options.GROOM, settings=shown)
    low, high = mesh.box()
    points = (mesh.vertices - 0.5 * (low + high)) @ turning(up, "y").T / mesh.size()
    return replace(scene, camera=framed(replace(scene.camera, fit=FILLED), points, scene.image.size))
