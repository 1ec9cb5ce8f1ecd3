"""`strandcli schema`: the JSON Schema of presets."""

from __future__ import annotations

from pathlib import Path

import click

from . import options


@click.command()
@click.option(
    "-o", "--output", type=options.PathType(), metavar="FILE", help="Write it there.  [default: stdout]"
)
@options.overwrite
@options.debug
def command(output: Path | None, overwrite: bool) -> None:
    """Print the JSON Schema of presets, for editors.

    For the YAML language server, write it to strandcli.schema.json and begin a preset with
    '# yaml-language-server: $schema=strandcli.schema.json'.
    """
    from ..scene import json_schema
    from ..simulate.rules import registry

    schema = json_schema(registry())
    if output is None:
        options.print_json(schema)
        return
    from ..output.files import write_json

    options.refuse_existing(output, overwrite)
    write_json(output, schema)
