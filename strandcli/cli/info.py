"""`strandcli info`: what is in files of strands."""

from __future__ import annotations

from pathlib import Path

import click

from . import options, strand_files


@click.command()
@click.argument("file", type=options.PathType(), metavar="FILE")
@strand_files.reading
@options.as_json
@options.debug
def command(file: Path, stride: int | None, array: str | None, as_json: bool) -> None:
    """Tell what is in a FILE of strands: counts, lengths, box, curvature, guesses of roots, up axis and unit; faults,
    with the option of 'convert' that mends each."""
    from ..exchange.facts import facts_of_file
    from ..exchange.files import ReadOptions

    found = facts_of_file(file, ReadOptions(stride, array))
    if as_json:
        options.print_json(found.as_dict())
    else:
        strand_files.say_facts(found)
