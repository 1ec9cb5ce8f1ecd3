"""`strandcli warmup`: compile ahead."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..common.counted import counted
from ..common.limits import cores
from ..compiling import processor
from ..compiling.clock import clock
from ..compiling.folder import cache
from . import completion, options, signals
from .progress import Talk
from .render_options import layer_options, with_layers

if TYPE_CHECKING:
    from ..scene.model import Scene

FRAMES = 2
"""Of each preset that are drawn with all threads: the second meets kernels of what moves. The first is drawn again with
one thread, as are several frames at once: some kernels are of one or the other."""

WIDTHS = (8, 8, 9, 8, 10, 13, 11, 9)
"""Columns of figures in the table of --profile."""


@click.command()
@click.argument("presets", nargs=-1, metavar="[PRESET|FILE]... | all", shell_complete=completion.presets)
@options.scene_options
@options.quality
@layer_options
@click.option("--pack", type=options.PathType(), metavar="FILE", help="Also write the kernels as one file.")
@click.option(
    "--cpu", type=click.Choice(tuple(processor.LEVELS)),
    help="Compile for all processors of a kind.  [default: for this machine's]",
)  # fmt: skip
@click.option("--profile", is_flag=True, help="Compile all anew, keep nothing, and tell what each kernel costs.")
@options.alone("pack", "profile")
@options.threads
@options.talk("Name each preset that is done, and what is compiled.")
def command(
    presets: tuple[str, ...], exr: bool, pack: Path | None, cpu: str | None, profile: bool, threads: int | None,
    talk: Talk, **scene_settings: Any,
) -> None:  # fmt: skip
    """Compile the kernels of PRESET, or of all shipped presets, so that the next run starts at once.

    Give the options that the run will have: they decide which kernels it needs. Two frames of each preset are drawn,
    and not stored. A pack serves machines that have the same Python, Numba and system, and a processor of the kind that
    --cpu names, where STRANDCLI_CACHE_PATH names it. --profile prints processor seconds of typing, lowering and LLVM,
    how often a kernel was compiled, and for which types of its arguments after the first time.
    """
    from ..output.files import require_folder

    if cpu is not None:
        processor.choose(cpu)
    if cores() == 1:
        os.environ.setdefault("NUMBA_NUM_THREADS", "2")
    if pack is not None:
        require_folder(pack.parent, 0)
    names = _names(presets)
    scenes = [with_layers(options.load_scene(name, **scene_settings), exr) for name in names]
    from ..compiling import runtime
    from ..jit.profile import profiled

    if pack is not None:
        cache.use(cache.path)  # all of it has to be in one folder, for one processor
        cache.arrays = False  # what computes them belongs to a pack
    with profiled() if profile else nullcontext() as measured, talk.compiled(len(names), "warmup", threads) as progress:
        for scene in scenes:
            clock.expect(scene.source)
        for name, scene in zip(names, scenes, strict=True):
            _draw(scene, threads, progress.note, pack is not None)
            progress.step(name)
    seconds = runtime.compile_seconds()
    data: dict[str, Any] = {
        "presets": names, "compile_seconds": seconds, "compiled": clock.compiled, "cache": str(cache.path),
        "kernels": dict(sorted(clock.ready.items())), "waited": dict(clock.waited.most_common()),
    }  # fmt: skip
    if pack is not None:
        data["pack"] = {"file": str(pack), **_write_pack(pack)}
    if measured is not None:
        data["profile"] = measured.costs()
    cache.arrays = True
    talk.data(data)
    if measured is not None and not talk.as_json:
        click.echo(_table(data["profile"]))
    if measured is None:
        done = f"compiled for {seconds:.1f} s" if seconds else "everything was compiled already"
        talk.note(f"warmup: {done}; kernels are in {cache.path}")
        if pack is not None:
            there = data["pack"]
            begun = f" and {counted(there['states'], 'settled first frame')}" if there["states"] else ""
            talk.note(f"warmup: {pack} has {there['kernels']} kernels{begun}, {there['bytes'] / 1e6:.1f} MB")


def _names(presets: tuple[str, ...]) -> list[str]:
    """The presets meant; all shipped ones for none, and for ``all``."""
    from ..scene import list_presets

    return [name for name, _ in list_presets()] if presets in ((), ("all",)) else list(presets)


def _draw(scene: Scene, threads: int | None, notify: Callable[[str], None], packed: bool) -> None:
    """Draw the first frames of a scene; ``packed``: and keep the state in which they begin."""
    from ..run import pipeline
    from ..run.checkpoints import Checkpoints

    states = Checkpoints(None) if packed else None
    for count, frames in ((threads, range(1, min(FRAMES, scene.time.frames) + 1)), (1, [1])):
        for _ in pipeline.render(scene, frames, threads=count, notify=notify, checkpoints=states):
            signals.check()


def _table(costs: list[dict[str, Any]]) -> str:
    """A line a kernel, the dearest first, and one of all."""
    seconds, counts = ("seconds", "typing", "lowering", "llvm"), ("functions", "instructions", "bytes", "compiled")
    whole = {name: sum(one[name] for one in costs) for name in (*seconds, *counts)}
    lines = ["".join(f"{name:>{wide}}" for name, wide in zip((*seconds, *counts), WIDTHS, strict=True)) + "  kernel"]
    for one in (*costs, {**whole, "name": counted(len(costs), "kernel"), "why": []}):
        cells = [f"{one[name]:.2f}" for name in seconds] + [f"{one[name]:,}" for name in counts]
        row = "".join(f"{cell:>{wide}}" for cell, wide in zip(cells, WIDTHS, strict=True))
        lines.append("; ".join([f"{row}  {one['name']}", *one["why"]]))
    return "\n".join(lines)


def _write_pack(path: Path) -> dict[str, int]:
    """Write all kernels that were run, and states of first frames; returns how many they are, and the file's bytes."""
    from ..compiling.stores import packed
    from ..jit.cache import pack_content
    from ..output.files import prepare_folder, write_pieces

    made, entries = pack_content()
    content = packed(made, entries)
    prepare_folder(path.parent, len(content))
    write_pieces(path, [content])
    path.chmod(path.stat().st_mode & ~0o022)  # one that more than its owner may change is not run
    kernels = sum(name.endswith(".kernel") for name in entries)
    return {"kernels": kernels, "states": len(entries) - kernels, "bytes": len(content)}
