"""`strandcli presets`: what is shipped."""

from __future__ import annotations

from pathlib import Path

import click

from ..errors import UsageError
from . import completion, options
from .progress import print_json, say


@click.group(invoke_without_command=True)
@click.pass_context
def command(ctx: click.Context) -> None:
    """List, show or copy the presets that come with strandcli; lists them when nothing else is said."""
    if ctx.invoked_subcommand is None:
        ctx.invoke(list_all)


def belonging(preset: Path) -> list[Path]:
    """Files that a shipped preset reads: those that begin with its name, and meshes and pictures that it names."""
    import strandcli

    from ..scene.named_files import files_of

    text = preset.read_text(encoding="utf-8")
    found = {path for path in preset.parent.glob(f"{preset.stem}-*") if path.suffix not in (".yaml", ".yml")}
    for _, name, _ in files_of(strandcli.load(str(preset))):
        path = Path(name)
        inside = path.is_relative_to(preset.parent)
        if inside and path.relative_to(preset.parent).as_posix() in text:  # else what it extends names it
            found.add(path)
    return sorted(found)


@command.command("list")
@options.as_json
def list_all(as_json: bool = False) -> None:
    """List the shipped presets with their titles."""
    from ..scene import describe_preset, list_presets

    found = [(name, describe_preset(path)) for name, path in list_presets()]
    if as_json:
        print_json([{"name": name, "title": title} for name, title in found])
        return
    width = max((len(name) for name, _ in found), default=0)
    for name, title in found:
        say(f"{name:<{width}}  {title}".rstrip())


@command.command("show")
@click.argument("name", shell_complete=completion.shipped)
def show(name: str) -> None:
    """Print the file of a shipped preset."""
    from ..scene import find

    click.echo(find(name).read_text(encoding="utf-8"), nl=False)


@command.command("copy")
@click.argument("name", shell_complete=completion.shipped)
@click.argument("target", required=False, type=options.PathType())
@options.overwrite
@options.quiet
def copy(name: str, target: Path | None, overwrite: bool, quiet: bool) -> None:
    """Copy a shipped preset to TARGET, a file or a folder (by default this one), to be changed there."""
    from ..output.files import prepare_folder, write_pieces
    from ..scene import find

    source = find(name)
    path = target if target is not None else Path()
    if path.is_dir():
        path = path / source.name
    if not path.parent.is_dir():
        raise UsageError(f"{path.parent}: no such folder")
    options.refuse_existing(path, overwrite)
    beside = [] if path.parent.samefile(source.parent) else belonging(source)
    targets = {one: path.parent / one.relative_to(source.parent) for one in beside}
    wanted = {one: place for one, place in targets.items() if not _same(one, place)}
    for place in wanted.values():
        options.refuse_existing(place, overwrite)
    for one, place in {source: path, **wanted}.items():
        prepare_folder(place.parent, 0)
        write_pieces(place, [one.read_bytes()])
    if not quiet:
        say(f"{path}: copied from {name}; draw it with 'strandcli render {path}'", err=True)


def _same(one: Path, other: Path) -> bool:
    """Whether the second file is there and holds what the first does, as where two presets name one mesh."""
    return other.is_file() and other.read_bytes() == one.read_bytes()
