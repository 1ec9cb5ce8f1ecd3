"""`strandcli warmup`: compile ahead."""

from __future__ import annotations

import click

from . import options
from .progress import Progress


@click.command()
@click.argument("presets", nargs=-1, metavar="[PRESET]...")
@options.threads
@options.talk_options
def command(
    presets: tuple[str, ...],
    threads: int | None,
    as_json: bool,
    quiet: bool,
    verbose: bool,
    no_progress: bool,
) -> None:
    """Compile the kernels of PRESET, or of all shipped presets, so that the next run starts at once."""
    options.exclusive(quiet=quiet, verbose=verbose)
    from .. import runtime
    from ..scene import list_presets

    names = list(presets) or [name for name, _ in list_presets()]
    with Progress(len(names), "warmup", hidden=no_progress or quiet or as_json, verbose=verbose) as progress:
        runtime.start(threads, progress.note)
        runtime.warmup(names, progress.note)
    seconds = runtime.compile_seconds()
    if as_json:
        options.print_json({"presets": names, "compile_seconds": seconds, "cache": str(runtime.cache_folder())})
    if not quiet:
        told = f"compiled for {seconds:.1f} s" if seconds else "everything was compiled already"
        click.echo(f"warmup: {told}; kernels are in {runtime.cache_folder()}", err=True)
