"""`strandcli warmup`: compile ahead."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from . import complete, options, signals
from .progress import Progress
from .say import say

if TYPE_CHECKING:
    from ..scene.model import Scene

# Kernels depend on what a scene uses, not on how much of it: two frames of a small version compile all of them.
SIZE: dict[str, Any] = {"image.size": (64, 48)}
STRANDS = 128


@click.command()
@click.argument("presets", nargs=-1, metavar="[PRESET]...", shell_complete=complete.presets)
@options.threads
@options.talk("Name each preset that is done, and what is compiled.")
def command(
    presets: tuple[str, ...],
    threads: int | None,
    as_json: bool,
    quiet: bool,
    verbose: bool,
    no_progress: bool,
) -> None:
    """Compile the kernels of PRESET, or of all shipped presets, so that the next run starts at once."""
    from .. import runtime
    from ..scene import list_presets

    names = list(presets) or [name for name, _ in list_presets()]
    scenes = [_small(name) for name in names]
    with Progress(len(names), "warmup", hidden=no_progress or quiet, verbose=verbose) as progress:
        runtime.start(threads, progress.note)
        from .. import pipeline

        for name, scene in zip(names, scenes, strict=True):
            for _ in pipeline.render(
                scene, range(1, min(2, scene.time.frames) + 1), threads=threads, notify=progress.note
            ):
                signals.check()
            progress.step(name)
    seconds = runtime.compile_seconds()
    if as_json:
        options.print_json({"presets": names, "compile_seconds": seconds, "cache": str(runtime.cache_folder())})
    if not quiet:
        told = f"compiled for {seconds:.1f} s" if seconds else "everything was compiled already"
        say(f"warmup: {told}; kernels are in {runtime.cache_folder()}", err=True)


def _small(name: str) -> Scene:
    """A preset with few strands and pixels."""
    import strandcli

    scene = strandcli.load(name, settings=SIZE)
    strands = "emitter.strands" if scene.emitter.groom is None else "emitter.groom.strands"
    return strandcli.load(name, settings=SIZE | {strands: STRANDS})
