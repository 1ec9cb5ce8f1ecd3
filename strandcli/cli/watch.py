"""`strandcli render --watch`: a frame drawn anew whenever the preset is saved."""

from __future__ import annotations

import dataclasses
import gc
import sys
import tempfile
import time
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import MismatchError, StrandError, UsageError
from ..files import inputs
from . import options, signals
from .preview import Preview
from .progress import Progress, say

if TYPE_CHECKING:
    from ..scene.model import Scene

FILE = "watch.png"
PAUSE = 0.01
"""Seconds between two looks at the files."""
SIDE = 400
"""Pixels of the longer side, where no --size is given."""
NOT_WITH = ("resume", "animate", "over", "max_error", "exr", "from_cache", "cameras", "camera", "sweep", "aovs", "dask")

watch_option = click.option(
    "--watch", is_flag=True, help=f"Draw one frame as a draft into {FILE}, and again whenever the preset is saved."
)


def run(given: Mapping[str, Any]) -> None:
    """Draw the first frame asked for until Ctrl-C, by the arguments of the command ``render``."""
    for name in NOT_WITH:
        if given[name]:
            raise UsageError(f"--watch draws one frame again and again: --{name.replace('_', '-')} does not go with it")
    folder = given["output"] or options.default_folder(given["preset"])
    path = folder / FILE
    frame = given["frames"].numbers()[0] if given["frames"] is not None else 1
    from ..compiling import runtime
    from ..output import png
    from ..output.files import prepare_folder, require_own

    if not given["overwrite"]:
        require_own(path, lambda path: png.keyword(path, "Software") == "strandcli")
    prepare_folder(folder, 0)
    preview = Preview(given["preview"])
    files: Collection[inputs.Input] | None = None
    runtime.start(given["threads"])
    if not given["quiet"]:
        say(f"{given['preset']}: drawn into {path} whenever it is saved; Ctrl-C ends", err=True)
    try:
        with tempfile.TemporaryDirectory(prefix="strandcli-watch-", ignore_cleanup_errors=True) as states:
            while True:
                if files is None or not all(map(inputs.is_current, files)):
                    gc.disable()  # to look at all that libraries hold takes a tenth of a second, and is done after
                    with inputs.recording() as files:
                        inputs.note(given["preset"])
                        _round(given, path, frame, preview, Path(states))
                    gc.collect()
                    gc.freeze()
                    gc.enable()
                signals.check()
                time.sleep(PAUSE)
    except KeyboardInterrupt as end:
        if type(end) is not KeyboardInterrupt:  # SIGTERM and SIGHUP
            raise


def _round(given: Mapping[str, Any], path: Path, frame: int, preview: Preview, states: Path) -> None:
    """Draw once; faults are shown in place, and the picture before stays."""
    start = time.perf_counter()
    quiet = given["quiet"]
    try:
        image, compiling = _drawn(_scene(given), frame, given, states)
        from ..output.files import write_pieces
        from ..output.png import encode

        write_pieces(path, encode(image, {"Software": "strandcli"}))
        preview.show(image, alone=True)
        if not quiet:
            more = f", of which {compiling:.1f} s compiling" if compiling > 0.05 else ""
            _in_place(f"{path}: frame {frame} in {time.perf_counter() - start:.2f} s{more}")
    except (StrandError, MemoryError) as error:
        if isinstance(error, MismatchError):
            raise
        _in_place(str(error) or "out of memory; ask for fewer --strands or a smaller --size")


def _scene(given: Mapping[str, Any]) -> Scene:
    """The scene as a draft, unless a quality is asked for, and small, unless a size is."""
    names = ("size", "strands", "particles", "seed", "overrides")
    settings = {name: given[name] for name in names} | {"quality": given["quality"] or "draft"}
    scene = options.load_scene(given["preset"], **settings)
    share = SIDE / max(scene.image.size)
    if settings["size"] is None and share < 1 and not scene.panels:
        settings["size"] = tuple(max(1, round(side * share)) for side in scene.image.size)
        scene = options.load_scene(given["preset"], **settings)
    return scene if given["quality"] else _with_one_turn(scene)


def _with_one_turn(scene: Scene) -> Scene:
    """The scene with no more of a loop before its first frame than one turn, at the end of which strands that settle
    are nearly where a further one would bring them: those of `hair` .11 mm off on average, 2.9 mm at the most."""
    if scene.panels:
        return dataclasses.replace(scene, panels=tuple(_with_one_turn(panel) for panel in scene.panels))
    time = scene.time
    preroll = min(time.preroll, time.frames / time.fps) if time.loop else time.preroll
    return dataclasses.replace(scene, time=dataclasses.replace(time, preroll=preroll))


def _drawn(scene: Scene, frame: int, given: Mapping[str, Any], states: Path) -> tuple[Any, float]:
    """The picture, and the seconds that compiling took."""
    quiet = given["quiet"]
    from ..compiling import runtime
    from ..plan import checked_plan
    from ..run import pipeline
    from ..run.checkpoints import Checkpoints

    if frame > scene.time.frames:
        raise UsageError(f"-f/--frames asks for frame {frame}, but the animation has {scene.time.frames}")
    checked_plan(scene, [frame])
    every = max(1, frame - 1) if scene.camera.shutter > 0 else frame  # what moves is drawn between two frames
    before = runtime.compile_seconds()
    with Progress(1, options.preset_name(given["preset"]), hidden=quiet or given["no_progress"]) as progress:
        (found,) = pipeline.render(
            scene, [frame], threads=given["threads"], notify=progress.note, keep_going=given["keep_going"],
            warn=lambda text: None if quiet else progress.line(f"warning: {text}"),
            checkpoints=Checkpoints(states, every, notify=progress.note),
        )  # fmt: skip
    return found.image, runtime.compile_seconds() - before


def _in_place(text: str) -> None:
    """Say what the last round came to; on a terminal in place of what it said before."""
    clear = "\x1b[H\x1b[2J" if sys.stderr.isatty() and not sys.stdout.isatty() else ""
    click.echo(clear, err=True, nl=False)
    say(text, err=True)
