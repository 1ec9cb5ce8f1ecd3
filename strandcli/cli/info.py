"""`strandcli info`: what is in files of strands and of meshes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..errors import UsageError
from ..meshes import SUFFIXES
from . import facts, options
from .say import print_json, say

if TYPE_CHECKING:
    from ..exchange.files import ReadOptions
    from ..scene.model import Scene


@click.command()
@click.argument("file", type=options.PathType(), metavar="FILE")
@facts.reading
@click.option(
    "--picture", type=options.PathType(), metavar="FILE", help="Also draw them into a PNG, as 'strandcli render' does."
)
@click.option(
    "--on", type=options.PathType(), metavar="MESH",
    help="Also report whether strands fit this head in unit and up axis, and the option that mends it.",
)  # fmt: skip
@options.overwrite
@options.as_json
@options.debug
def command(
    file: Path, stride: int | None, array: str | None, objects: tuple[str, ...], picture: Path | None,
    on: Path | None, overwrite: bool, as_json: bool,
) -> None:  # fmt: skip
    """Describe a FILE of strands: counts, lengths, box, guesses of roots, up axis and unit; faults, with the
    option of 'convert' that mends each. Of a mesh (.obj, .ply, .stl, .glb or .gltf with faces): counts, box,
    area, volume, attributes, faults."""
    from ..exchange.facts import facts_of_file
    from ..exchange.files import ReadOptions

    if picture is not None:
        options.require_png(picture, "--picture")
        options.refuse_existing(picture, overwrite)
    if _mesh(file):
        if on is not None:
            raise UsageError(f"--on: {file} is a mesh itself; name a file of strands, and the mesh after --on")
        _report_mesh(file, picture, as_json)
        return
    how = ReadOptions(stride, array, objects=objects)
    found = facts_of_file(file, how)
    fit = None
    if on is not None:
        from ..exchange.files import files_of
        from ..groom_file import fits  # Numba comes with it
        from ..solid_shapes.mesh import Settings

        fit = fits.facts_on(files_of(file)[0], replace(how, lenient=True), Settings(file=str(on)))
    if as_json:
        print_json(found if fit is None else {**found, "on": fit})
    else:
        facts.say_facts(found)
        if fit is not None:
            say(f"  on mesh    {fit['mesh']}: {fits.said(fit)}")
    if picture is not None:
        _draw(file, how, picture)


def _draw(file: Path, how: ReadOptions, picture: Path) -> None:
    """Write a picture of a file of strands, by the preset for them."""
    import strandcli

    settings = {"file": str(file), "stride": how.stride, "array": how.array, "object": list(how.objects)}
    scene = strandcli.load(
        options.GROOM, settings={f"emitter.groom.{key}": one for key, one in settings.items() if one}
    )
    _write(scene, picture)


def _mesh(file: Path) -> bool:
    """Whether a file is one of a mesh; meshes take Numba."""
    if file.suffix.lower() not in SUFFIXES:
        return False
    from ..exchange.files import files_of
    from ..meshes.facts import is_mesh

    return is_mesh(files_of(file)[0])


def _report_mesh(file: Path, picture: Path | None, as_json: bool) -> None:
    """Say what is in a file of a mesh, and draw it."""
    from ..meshes.facts import facts_of_file

    data, mesh = facts_of_file(file)
    if as_json:
        print_json(data)
    else:
        facts.say_facts(data)
    if picture is not None:
        _write(facts.scene_of(file, mesh, data["guess"]["up"] or "y"), picture)


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
