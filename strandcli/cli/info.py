"""`strandcli info`: what is in files of strands and of meshes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..common.counted import counted
from ..errors import UsageError
from ..meshes import SUFFIXES
from . import options
from .progress import print_json, say

if TYPE_CHECKING:
    from ..exchange.files import ReadOptions
    from ..meshes.mesh import TriangleMesh
    from ..scene.model import Scene

MOST_OBJECTS = 20
"""Objects that are printed for people."""
FILLED = 0.86
"""Share of a picture that a mesh fills."""


@click.command()
@click.argument("file", type=options.PathType(), metavar="FILE")
@options.reading
@click.option(
    "--picture", type=options.PathType(), metavar="FILE", help="Also draw them into a PNG, as 'strandcli render' does."
)
@click.option(
    "--on", type=options.PathType(), metavar="MESH",
    help="Also report whether strands fit this head in unit and up axis, and the option that mends it.",
)  # fmt: skip
@options.overwrite
@options.as_json
def command(
    file: Path, stride: int | None, array: str | None, objects: tuple[str, ...], picture: Path | None,
    on: Path | None, overwrite: bool, as_json: bool,
) -> None:  # fmt: skip
    """Describe a FILE of strands: counts, lengths, box, guesses of roots, up axis and unit; faults, with the
    option of 'convert' that mends each. Of a mesh (.obj, .ply, .stl, .glb or .gltf with faces): counts, box,
    area, volume, attributes, faults."""
    from ..exchange.facts import facts_of_file
    from ..exchange.files import ReadOptions, files_of

    if picture is not None:
        options.require_png(picture, "--picture")
        options.refuse_existing(picture, overwrite)
    how, mesh = ReadOptions(stride, array, objects=objects), _mesh(file)
    if mesh is not None and on is not None:
        raise UsageError(f"--on: {file} is a mesh itself; name a file of strands, and the mesh after --on")
    data = facts_of_file(file, how) if mesh is None else mesh[0]
    if on is not None:
        from ..groom_file import fits  # Numba comes with it
        from ..solid_shapes.mesh import Settings

        data = {**data, "on": fits.facts_on(files_of(file)[0], replace(how, lenient=True), Settings(file=str(on)))}
    if as_json:
        print_json(data)
    else:
        say_facts(data)
    if picture is not None:
        _write(_scene(file, how) if mesh is None else scene_of(file, mesh[1], data["guess"]["up"] or "y"), picture)


def _scene(file: Path, how: ReadOptions) -> Scene:
    """A file of strands by the preset for them."""
    import strandcli

    settings = {"file": str(file), "stride": how.stride, "array": how.array, "object": list(how.objects)}
    return strandcli.load(options.GROOM, settings={f"emitter.groom.{key}": one for key, one in settings.items() if one})


def _mesh(file: Path) -> tuple[dict[str, Any], TriangleMesh] | None:
    """The facts of a mesh and itself, where a file is one; meshes take Numba."""
    if file.suffix.lower() not in SUFFIXES:
        return None
    from ..exchange.files import files_of
    from ..meshes.facts import facts_of_file, is_mesh

    return facts_of_file(file) if is_mesh(files_of(file)[0]) else None


def _write(scene: Scene, picture: Path) -> None:
    """Draw the first frame of a scene into a PNG."""
    from ..output.files import write_pieces
    from ..output.png import encode
    from ..plan import checked_plan
    from ..run import pipeline

    checked_plan(scene, [1])
    (frame,) = pipeline.render(scene, [1])
    assert frame.image is not None
    write_pieces(picture, encode(frame.image))


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
    if "on" in data:
        from ..groom_file.fits import said

        yield "on mesh", f"{data['on']['mesh']}: {said(data['on'])}"


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
