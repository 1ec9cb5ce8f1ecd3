"""`--cameras`: views from a file of another program."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..errors import UsageError
from . import options

if TYPE_CHECKING:
    from ..cameras.read import Views

_file = click.option(
    "--cameras", type=options.PathType(), metavar="FILE",
    help="Views of a file or folder: transforms.json, COLMAP text, dataset.json, USD.",
)  # fmt: skip

cameras = options.together(
    _file, click.option("--camera", metavar="NAME", help="Which camera to use, where a USD file has several.")
)

PLACED = ("emitter.groom.size=null", "emitter.groom.place=file")
"""Strands where their file has them, which is where cameras from elsewhere look for them."""
USD = (".usd", ".usda", ".usdc")
"""Files of strands that tell their unit and up axis themselves."""


def world(preset: str, found: Views, path: Path | None) -> tuple[str, ...]:
    """What is set so that a scene is in the world of its cameras, as after --set: a file of strands is drawn where it
    stands unless strandcli wrote the cameras, of a scene in metres, into another file."""
    if not options.is_groom(preset):
        return ()
    together = path is not None and path.absolute() == Path(preset).absolute()
    if found.own and not together:
        return ()
    if Path(preset).suffix.lower() in USD and path is not None and path.suffix.lower() in USD and not together:
        return (*PLACED, "emitter.groom.scale=null", "emitter.groom.up=auto")
    return (*PLACED, f"emitter.groom.scale={found.unit!r}", f"emitter.groom.up={found.up}", *_lights(found))


def _lights(found: Views) -> tuple[str, ...]:
    """What is set so that light comes from above where the cameras' up is not y: the lights of the preset that strands
    of a file are drawn with, turned."""
    from ..cameras.pinhole import UP, upright
    from ..scene.loading import load
    from ..scene.model import DirectionalLight

    if found.above == UP:
        return ()
    turn, changes = upright(found.above), []
    for number, light in enumerate(load(options.GROOM, rules={}).lights):
        if isinstance(light, DirectionalLight):
            x, y, z = turn @ light.direction
            changes.append(f"lights.{number}.direction=[{x:.9f}, {y:.9f}, {z:.9f}]")
    return tuple(changes)


def require_file(path: Path | None, name: str | None) -> None:
    """Raise `UsageError` for the name of a camera without a file."""
    if name is not None and path is None:
        raise UsageError("--camera: names a camera of a file; add --cameras FILE")


def film(
    preset: str, path: Path, size: tuple[int, int] | None, name: str | None
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """What is set for a film of the views of a file, and what a person should know of them. Raises `UsageError` for a
    file that cannot be drawn, and for a size that is not its own."""
    from ..cameras.read import file_of, views_of

    found = views_of(path, size, (1, 1), name or "")
    place = file_of(path).absolute()
    return (
        *world(preset, found, path), "camera.keys=[]", f"camera.file={place}", f'camera.name="{name or ""}"',
    ), found.notes  # fmt: skip
