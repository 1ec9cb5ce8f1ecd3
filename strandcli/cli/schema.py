"""`strandcli schema`: the JSON Schema of presets."""

from __future__ import annotations

import json
from pathlib import Path

import click

from . import options


@click.command()
@click.option("-o", "--output", type=options.PathType(), metavar="FILE", help="Write it there.  [default: stdout]")
@click.option("--markdown", is_flag=True, help="Print a reference to read, as Markdown, instead.")
@options.overwrite
def command(output: Path | None, markdown: bool, overwrite: bool) -> None:
    """Print the JSON Schema of presets, for editors, or the reference of all settings as Markdown.

    For the YAML language server, write it to strandcli.schema.json and begin a preset with
    '# yaml-language-server: $schema=strandcli.schema.json'.
    """
    from ..simulate.rules import registry

    if markdown:
        from ..scene.schema import markdown as reference

        text = reference(registry())
    else:
        from ..scene import json_schema

        text = json.dumps(json_schema(registry()), indent=2, ensure_ascii=False) + "\n"
    if output is None:
        click.echo(text, nl=False)
        return
    from ..output.files import write_pieces

    options.refuse_existing(output, overwrite)
    write_pieces(output, [text.encode()])
