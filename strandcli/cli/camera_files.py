"""`--cameras`: views from a file of another program."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from . import options

if TYPE_CHECKING:
    from ..cameras.read import Views

cameras = click.option(
    "--cameras", type=options.PathType(), metavar="FILE",
    help="Views of a file or folder: transforms.json, COLMAP text, cameras.npz, dataset.json.",
)  # fmt: skip

OWN_WORLD = ("emitter.groom.size=null", "emitter.groom.scale=1", "emitter.groom.place=file", "emitter.groom.up=y")
"""Strands where their file has them, which is where cameras from elsewhere look for them."""


def world(preset: str, found: Views) -> tuple[str, ...]:
    """What is set so that a scene is in the world of its cameras, as after --set: a file of strands is drawn where it
    stands unless strandcli wrote the cameras, of a scene in metres."""
    return OWN_WORLD if options.is_groom(preset) and not found.own else ()


def film(preset: str, path: Path, size: tuple[int, int] | None) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """What is set for a film of the views of a file, and what a person should know of them. Raises `UsageError` for a
    file that cannot be drawn, and for a size that is not its own."""
    from ..cameras.read import file_of, views_of

    found = views_of(path, size, assumed=(1, 1))
    return (*world(preset, found), "camera.keys=[]", f"camera.file={file_of(path).absolute()}"), found.notes
