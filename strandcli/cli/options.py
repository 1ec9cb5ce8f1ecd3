"""Options that several commands share, each written down once."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from ..common.counted import counted
from ..common.limits import cores
from ..errors import UsageError
from ..meshes import SUFFIXES
from . import completion
from .progress import Talk, say
from .values import FRAMES, SIZE, FrameRange

if TYPE_CHECKING:
    from ..scene.model import Scene

F = TypeVar("F", bound=Callable[..., Any])


class Whole(click.IntRange):
    """A whole number within bounds."""

    name = "whole number"


COUNT_STRANDS = Whole(1, 100_000_000)
COUNT_PARTICLES = Whole(2, 100_000)


def _available(ctx: click.Context, param: click.Parameter, count: int | None) -> int | None:
    """A number of threads that this machine has."""
    if count is not None and count > (there := cores()):
        raise click.BadParameter(f"{count} threads, but this process may use {counted(there, 'core')}", ctx, param)
    return count


def _assignment(ctx: click.Context, param: click.Parameter, values: tuple[str, ...]) -> tuple[str, ...]:
    for value in values:
        if not re.match(r"\s*[^\s=]+\s*=", value):
            raise click.BadParameter(f"'{value}' is not KEY=VALUE, such as wind.strength=3", ctx, param)
    return values


class PathType(click.Path):
    """The path of a file or a folder, which an empty text, as of a shell's variable that is not set, is not."""

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if str(value) == "":
            self.fail("the path is empty; write . for the folder that you are in", param, ctx)
        return super().convert(value, param, ctx)


def folder(default: str | None = None) -> Callable[[F], F]:
    """``-o/--output``; required where there is no default folder."""
    words = "Folder for the results." + (f"  [default: {default}]" if default else "")
    return click.option("-o", "--output", type=PathType(), metavar="DIR", required=not default, help=words)


preset = click.argument("preset", shell_complete=completion.presets)
drawn = click.argument("preset", metavar="PRESET|FILE", shell_complete=completion.presets)
frames = click.option("-f", "--frames", type=FRAMES, metavar="RANGE", help="Frames: 1-48 or 1-100x5,120.")
size = click.option("--size", type=SIZE, help="Width and height in pixels.")
strands = click.option("--strands", type=COUNT_STRANDS, metavar="N", help="Number of strands.")
particles = click.option("--particles", type=COUNT_PARTICLES, metavar="N", help="Particles a strand.")
count_of_threads = functools.partial(click.option, "--threads", type=Whole(1), callback=_available, metavar="N")
threads = count_of_threads(help="Threads.  [default: all cores]")
seed = click.option("--seed", type=Whole(0, 2**63 - 1), metavar="N", help="Seed of everything random.")
quality = click.option(
    "--quality", type=click.Choice(("draft", "default", "best")),
    help="How finely to draw.  [default: the preset's own quality]",
)  # fmt: skip
overrides = click.option(
    "--set", "overrides", multiple=True, metavar="KEY=VALUE", callback=_assignment, shell_complete=completion.keys,
    help="Change one value of the preset, such as wind.strength=3. Repeatable.",
)  # fmt: skip
objects = click.option(
    "--object", "objects", multiple=True, metavar="NAME",
    help="Only the strands of this object of a file; 'strandcli info' lists them. Repeatable.",
)  # fmt: skip
keep_going = click.option(
    "--keep-going", is_flag=True,
    help="Do not stop where a run goes wrong; strands that are no longer finite are left out of the pictures.",
)  # fmt: skip
checkpoint = click.option(
    "--checkpoint", type=Whole(1), metavar="N",
    help="Save the simulation's state every N frames in DIR/checkpoints, for later runs to start from.",
)  # fmt: skip
memory_check = click.option(
    "--no-memory-check", "memory_check", is_flag=True, flag_value=False, default=True,
    help="Run even if the plan needs over 80 % of free memory.",
)  # fmt: skip
resume = click.option("--resume", is_flag=True, help="Skip complete files of an earlier run.")
overwrite = click.option("--overwrite", is_flag=True, help="Replace existing files.")
from_cache = click.option(
    "--from-cache", type=PathType(), metavar="DIR",
    help="Draw the positions that 'strandcli simulate' left in DIR.",
)  # fmt: skip
as_json = click.option("--json", "as_json", is_flag=True, help="Print machine data, and nothing else, on stdout.")
quiet = click.option("-q", "--quiet", is_flag=True, help="Print errors only.")
no_progress = click.option("--no-progress", is_flag=True, help="No progress line, even on a terminal.")


def together(*decorators: Callable[[Any], Any]) -> Callable[[F], F]:
    """Several options as one decorator, listed by --help in the order given."""

    def apply(function: F) -> F:
        for decorate in reversed(decorators):
            function = decorate(function)
        return function

    return apply


def alone(*names: str) -> Callable[[F], F]:
    """Let at most one of some options be given; raises ``UsageError`` for more, before the command begins."""

    def decorate(function: F) -> F:
        @functools.wraps(function)
        def checked(*args: Any, **given: Any) -> Any:
            exclusive(**{name: given[name] for name in names})
            return function(*args, **given)

        return checked  # type: ignore[return-value]

    return decorate


def _with_talk(function: F) -> F:
    """Hand a command `Talk` in place of its options."""

    @functools.wraps(function)
    def talking(*args: Any, **given: Any) -> Any:
        asked = {name: given.pop(name) for name in Talk._fields if name in given}
        return function(*args, talk=Talk(**asked), **given)

    return talking  # type: ignore[return-value]


reading = together(
    click.option(
        "--stride", type=Whole(2, 1_000_000), metavar="N",
        help="Points a strand, where a file has vertices alone.",
    ),
    click.option("--array", metavar="NAME", help="Array of the points, where an .npz file has several."),
    objects,
)  # fmt: skip
resume_or_overwrite = together(alone("overwrite", "resume"), resume, overwrite)
scene_options = together(size, strands, particles, seed, objects, overrides)


def talk(more: str) -> Callable[[F], F]:
    """How much a command says; ``more`` is what it does with --verbose."""
    verbose = click.option("-v", "--verbose", is_flag=True, help=more)
    return together(alone("quiet", "verbose"), as_json, quiet, verbose, no_progress, _with_talk)


talk_options = talk("Print a line for each frame.")
brief = together(as_json, quiet, _with_talk)


def load_scene(
    preset: str, *, size: tuple[int, int] | None = None, strands: int | None = None, particles: int | None = None,
    seed: int | None = None, quality: str | None = None, objects: tuple[str, ...] = (),
    overrides: tuple[str, ...] = (), aovs: Sequence[str] | None = None,
) -> Scene:  # fmt: skip
    """The preset with what the common options change. Says on stderr where a shipped name hides a file."""
    import strandcli

    from ..scene.library import hidden_by_shipped

    hidden = hidden_by_shipped(preset)
    context = click.get_current_context(silent=True)
    if hidden is not None and not (context is not None and context.params.get("quiet")):
        say(f"{preset}: takes the shipped preset of this name; write {hidden} for yours", err=True)

    chosen: dict[str, Any] = {
        "image.size": size,
        "emitter.strands": strands,
        "emitter.particles": particles,
        "seed": seed,
        "quality": quality,
        "image.aovs": None if aovs is None else list(aovs),
        "emitter.groom.object": list(objects) or None,
    }
    settings = {path: value for path, value in chosen.items() if value is not None}
    if is_groom(preset):
        settings["emitter.groom.file"] = preset
        preset = GROOM
    elif Path(preset).suffix.lower() in SUFFIXES:
        from ..exchange.formats.obj import IS_MESH

        raise UsageError(f"{preset}: {IS_MESH}")
    return strandcli.load(preset, overrides=overrides, settings=settings, option="--set")


GROOM = "groom"
"""The preset that files of strands are drawn with."""


def is_groom(given: str) -> bool:
    """Whether what is given in a preset's place is a file of strands, by the end of its name."""
    suffix = Path(given).suffix.lower()
    if suffix in ("", ".yaml", ".yml"):
        return False
    from ..exchange.files import drivers

    return any(suffix in one.suffixes for one in drivers())


def frame_numbers(frames: FrameRange | None, scene: Scene, from_cache: Path | None = None) -> tuple[int, ...]:
    """The frames asked for, or all of the film's; of the folder of --from-cache, all that it can show."""
    if frames is not None:
        return frames.within(scene.time.frames)
    numbers = tuple(range(1, scene.time.frames + 1))
    if from_cache is None:
        return numbers
    from ..output.positions import cached_frames

    there = set(cached_frames(from_cache))
    before = 1 if scene.camera.shutter > 0 else 0  # what moves is drawn between two frames
    found = tuple(f for f in numbers if f in there and (f == 1 or f - before in there))
    if not found:
        raise UsageError(f"{from_cache}: has positions for none of the frames 1 to {scene.time.frames} of the preset")
    return found


def preset_name(preset: str) -> str:
    """A preset's name without what makes it a file: ``figures/fig02``, and ``hair`` of ``/tmp/hair.yaml``. It is text
    whatever the bytes of the path and the locale are."""
    return _stem(preset).encode("utf-8", "surrogateescape").decode("utf-8", "replace")


def _stem(preset: str) -> str:
    return Path(preset).stem if preset.endswith((".yaml", ".yml")) or is_groom(preset) else preset


def default_folder(preset: str) -> Path:
    """Where a command writes when -o is not given: out/PRESET."""
    parts = [part for part in Path(_stem(preset)).parts if part not in ("/", "..")]
    return Path("out", *parts)


def refuse_existing(path: Path, overwrite: bool) -> None:
    """Raise ``UsageError`` if a file is in the way and --overwrite was not given."""
    if path.exists() and not overwrite:
        raise UsageError(f"{path}: is there already; add --overwrite to replace it")


def require_png(path: Path, option: str = "-o") -> None:
    """Raise ``UsageError`` for a name that promises another kind of image than the one that is written."""
    if path.suffix.lower() != ".png":
        raise UsageError(f"{option} {path}: is written as PNG; let its name end in .png")


def exclusive(**flags: bool) -> None:
    """Raise ``UsageError`` if more than one of the flags is set."""
    given = ["--" + name.replace("_", "-") for name, is_set in flags.items() if is_set]
    if len(given) > 1:
        raise UsageError(f"{' and '.join(given)} exclude each other")
