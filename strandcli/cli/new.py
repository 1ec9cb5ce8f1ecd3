"""`strandcli new`: a first preset."""

from __future__ import annotations

import re
from pathlib import Path

import click

from ..errors import UsageError, one_line
from . import options
from .progress import say

SUFFIXES = (".yaml", ".yml")
LONGEST = 100
"""Characters of a name: file systems take 255 bytes, and frames' folders and temporary files have longer names."""
RESERVED = re.compile(r"(con|prn|aux|nul|com[0-9]|lpt[0-9])(\..*)?", re.IGNORECASE)
"""Names that Windows keeps for devices."""


@click.command()
@click.argument("name", type=options.PathType())
@click.option("--groom", type=options.PathType(), metavar="FILE", help="Draw the strands of this file.")
@click.option(
    "--head", type=options.PathType(), metavar="MESH",
    help="Have strands grow on this mesh, or lie on it with --groom (.obj, .ply, .stl, .glb, .gltf).",
)  # fmt: skip
@options.overwrite
@options.quiet
def command(name: Path, groom: Path | None, head: Path | None, overwrite: bool, quiet: bool) -> None:
    """Write the preset NAME.yaml, with a comment on each part, that 'strandcli render NAME.yaml' draws as it is.

    Without a file it is hair on a ball. Units and up axes of --groom and --head come from the files, or are guessed,
    or measured by how the roots lie on the head; the preset says which.
    """
    path = preset_file(name)
    options.refuse_existing(path, overwrite)
    from ..output.files import write_pieces
    from . import new_preset as new

    on = None if head is None else new.mesh(_there(head, "--head"), path)
    warning, placed = None, None
    if groom is not None and on is not None and head is not None:
        placed, warning = new.strands_on(_there(groom, "--groom"), on, head, path)
    elif groom is not None:
        placed = new.strands(_there(groom, "--groom"), path)
    strands = "Hair" if groom is None else f"The strands of {groom.name}"
    where = f" on {head.name}" if head is not None else " on a ball that turns" if groom is None else ""
    write_pieces(path, [new.text(one_line(strands + where), path.name, path.stem, placed, on).encode()])
    if warning is not None:
        say(f"warning: {warning}", err=True)
    if not quiet:
        say(f"{path}: written; draw it with 'strandcli render {path} -f 1'", err=True)


def preset_file(name: Path) -> Path:
    """The file of a preset of this name, in a folder that is there. Raises ``UsageError`` for names that a shell, a
    file system or strandcli would take for something else."""
    shown = one_line(str(name))
    stem = name.name.removesuffix(name.suffix) if name.suffix.lower() in SUFFIXES else name.name
    if name.suffix and name.suffix.lower() not in SUFFIXES:
        raise UsageError(
            f"{shown}: a preset is a .yaml file; name it {one_line(name.stem)}.yaml, or {one_line(name.stem)}"
        )
    if not re.fullmatch(r"\w[\w-]*", stem) or RESERVED.fullmatch(stem) or len(stem) > LONGEST:
        raise UsageError(
            f"{shown}: is no name for a preset; take letters, digits, - and _, up to {LONGEST} in all, such as my_hair"
        )
    if not name.parent.is_dir():
        raise UsageError(f"{one_line(str(name.parent))}: no such folder; make it first")
    return name if name.suffix.lower() in SUFFIXES else name.with_name(f"{stem}.yaml")


def _there(path: Path, option: str) -> Path:
    if not path.is_file():
        raise UsageError(f"{option} {one_line(str(path))}: no such file")
    return path
