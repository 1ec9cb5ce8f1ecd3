"""`strandcli info`: what is in files of strands."""

from __future__ import annotations

from pathlib import Path

import click

from . import options, strand_files


@click.command()
@click.argument("file", type=options.PathType(), metavar="FILE")
@strand_files.reading
@click.option(
    "--picture", type=options.PathType(), metavar="FILE", help="Also draw them into a PNG, as 'strandcli render' does."
)
@options.overwrite
@options.as_json
@options.debug
def command(
    file: Path, stride: int | None, array: str | None, picture: Path | None, overwrite: bool, as_json: bool
) -> None:
    """Tell what is in a FILE of strands: counts, lengths, box, curvature, guesses of roots, up axis and unit; faults,
    with the option of 'convert' that mends each."""
    from ..exchange.facts import facts_of_file
    from ..exchange.files import ReadOptions

    if picture is not None:
        options.require_png(picture, "--picture")
        options.refuse_existing(picture, overwrite)
    found = facts_of_file(file, ReadOptions(stride, array))
    if as_json:
        options.print_json(found.as_dict())
    else:
        strand_files.say_facts(found)
    if picture is not None:
        _draw(file, stride, array, picture)


def _draw(file: Path, stride: int | None, array: str | None, picture: Path) -> None:
    """Write a picture of a file of strands, by the preset for them."""
    import strandcli

    from .. import pipeline
    from ..output.files import write_pieces
    from ..output.png import encode
    from ..plan import make_plan, require_memory

    settings = {"emitter.groom.file": str(file), "emitter.groom.stride": stride, "emitter.groom.array": array}
    scene = strandcli.load(options.GROOM, settings={key: one for key, one in settings.items() if one is not None})
    require_memory(make_plan(scene, [1]))
    (frame,) = pipeline.render(scene, [1])
    assert frame.image is not None
    write_pieces(picture, encode(frame.image))
