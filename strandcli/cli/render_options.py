"""Options of `strandcli render` that other commands share: views from a file of another program, layers, and animations
of the frames that are left, which and over which colour."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.shell_completion import CompletionItem

from ..errors import UsageError
from . import options, signals
from .completion import listed
from .options import together
from .progress import Talk
from .render_frames import interrupted
from .values import ANIMATIONS, COLOUR, KINDS, Parsed, layers

if TYPE_CHECKING:
    from ..cameras.read import Views
    from ..output.frames import FrameWriter
    from ..output.png import Rgb
    from ..scene.model import Scene

_file = click.option(
    "--cameras", type=options.PathType(), metavar="FILE",
    help="Views of a file or folder: transforms.json, COLMAP text, dataset.json, USD.",
)  # fmt: skip

cameras = together(
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


OPAQUE = ("gif", "mp4")
"""Kinds without alpha, or with one bit of it."""


def animation_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """``--animate`` and ``--over``."""
    kinds = click.option(
        "--animate", type=ANIMATIONS, metavar="KIND", help="Also write animation.gif, .webp, .mp4: gif,mp4."
    )
    over = click.option(
        "--over", type=COLOUR, metavar="COLOUR",
        help="Colour under frames without background, in GIF and MP4: white, '#rrggbb'.  [default: mid grey]",
    )  # fmt: skip
    return kinds(over(command))


def ground(scene: Scene, kinds: Sequence[str], over: Rgb | None) -> tuple[Rgb | None, bool]:
    """What the frames of a scene are put over, None for mid grey, and whether that is guessed: they have alpha, and no
    colour was named. Raises ``UsageError`` for a colour that nothing would be put over."""
    alpha = any(one.image.has_alpha for one in scene.panels or (scene,))
    if over is not None and not any(kind in OPAQUE for kind in kinds):
        raise UsageError("--over is for GIF and MP4, which have no alpha: add --animate gif or mp4, or leave it out")
    if over is not None and not alpha:
        raise UsageError("--over: the frames have a background; add --set image.background=none, or leave it out")
    return over, alpha and over is None


def animate(
    writer: FrameWriter, data: Mapping[str, Any], asked: Sequence[str], replace: bool, fps: float,
    under: tuple[Rgb | None, bool], talk: Talk,
) -> list[Path]:  # fmt: skip
    """Write the animations of a run with the report ``data``, of all frames of its scene in the folder: those that are
    ``asked`` for. Where a run that may ``replace`` files has drawn some of the frames, those that are there. Says what
    they could not do."""
    from ..output.animation import write_animation
    from ..output.frames import frame_file
    from ..output.png import GREY

    numbers, made = [entry["frame"] for entry in data["frames"]], []
    there = [kind for kind in KINDS if (writer.directory / f"animation.{kind}").exists()]
    some = replace and 0 < len(writer.wanted) < len(numbers)
    for kind in asked or (there if some else ()):
        made.append(path := writer.directory / f"animation.{kind}")
        paths = [writer.directory / frame_file(number) for number in numbers]
        try:
            signals.check()
            shown = write_animation(path, paths, numbers, fps, under[0] or GREY)
        except KeyboardInterrupt:
            talk.note(interrupted(writer, f"{path.name} is not written; "))
            raise
        if under[1] and kind in OPAQUE:
            talk.note(f"{path}: {kind} has no alpha: frames are over mid grey; name another colour by --over")
        if len(numbers) > 1 and shown < 0.99 * fps:
            talk.note(f"{path}: plays {shown:.3g} frames a second, all that {kind} can; {fps:g} were asked")
    return made


def _names(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    from ..scene.model import AOVS

    return listed(AOVS, incomplete)


layer_options = together(
    click.option(
        "--aov", "aovs", type=Parsed("LAYERS", layers), metavar="LAYERS", shell_complete=_names,
        help="Also write layers as .npz and PNG: depth, mask, solid, tangent, orientation, strand_id, shadow, linear.",
    ),
    click.option("--exr", is_flag=True, help="Also write frame_0001.exr: linear light, and the layers of --aov."),
)  # fmt: skip


def with_layers(scene: Scene, exr: bool) -> Scene:
    """The scene with what EXR files hold; raises ``UsageError`` where its layers cannot be written."""
    if (exr or scene.image.aovs) and scene.panels:
        asked = "--exr" if exr else "image.aovs"
        raise UsageError(f"{asked}: a preset of several panels has no layers; draw one without panels")
    if not exr:
        return scene
    from ..output.layers import require_exr

    require_exr(scene.drawn_strands)
    if "linear" in scene.image.aovs:
        return scene
    return replace(scene, image=replace(scene.image, aovs=(*scene.image.aovs, "linear")))
