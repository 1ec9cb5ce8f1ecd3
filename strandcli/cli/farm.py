"""`strandcli farm`: job files for a scheduler."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..common.counted import counted
from ..common.limits import cores
from ..errors import UsageError
from . import options
from .progress import Talk
from .values import ANIMATIONS, FrameRange

TARGETS = ("slurm", "parallel", "openjd")
NEXT = {"slurm": "sh {}/submit.sh", "parallel": "sh {}/run.sh", "openjd": "openjd run {}/job.yaml"}
MOST_THREADS, USUAL_THREADS = 4096, 4
HEAD = "# All settings of this job, as they were when it was written."


@click.command()
@options.drawn
@click.option("--target", type=click.Choice(TARGETS), required=True, help="What runs them.")
@options.folder("farm/PRESET")
@options.frames
@options.scene_options
@options.quality
@click.option(
    "--chunk", type=options.Whole(1, 100_000), metavar="N", help="Frames a task.  [default: 8, at most 1000 tasks]"
)
@click.option(
    "--threads",
    type=options.Whole(1, MOST_THREADS),
    metavar="N",
    help="Threads a task.  [default: 4, or as many as this machine has cores]",
)
@click.option("--animate", type=ANIMATIONS, metavar="KIND", help="Also join the frames as an animation.")
@options.keep_going
@options.overwrite
@options.brief
def command(
    preset: str, target: str, output: Path | None, frames: FrameRange | None, chunk: int | None, threads: int | None,
    animate: tuple[str, ...] | None, keep_going: bool, overwrite: bool, talk: Talk, **scene_settings: Any,
) -> None:  # fmt: skip
    """Write job files that draw PRESET with a scheduler: Slurm, GNU parallel, or one that takes Open Job Description.

    Kernels are compiled once, the scene is simulated once, chunks of frames are drawn side by side, and the results are
    checked, joined and reported. A copy of the preset with all its settings goes with the jobs, so that later changes
    to yours do not mix into the film. The jobs may be submitted again: finished work is not repeated.
    """
    from .. import farm as jobs
    from ..output.files import prepare_folder, write_pieces
    from ..plan import make_plan
    from ..scene import dump
    from ..scene.detail import with_before

    scene = options.load_scene(preset, **scene_settings)
    numbers = options.frame_numbers(frames, scene)
    folder = output or Path("farm", *options.default_folder(preset).parts[1:])
    options.refuse_existing(folder / jobs.SCENE, overwrite)
    try:
        chunks = jobs.chunks_of(numbers, chunk)
    except ValueError as error:
        raise UsageError(str(error)) from None
    extra = ("--keep-going",) if keep_going else ()
    threads = threads or min(USUAL_THREADS, cores())
    plan = make_plan(scene, numbers, threads=threads)
    moved = jobs.spelled(with_before(scene, numbers)) if plan.steps and not scene.panels else ""
    job = jobs.Job(
        options.preset_name(preset), jobs.spelled(numbers), chunks, moved,
        threads, jobs.asked_memory(plan.memory_at_once_bytes), ",".join(animate or ()), extra,
    )  # fmt: skip
    files = jobs.files(job, target, cores())
    prepare_folder(folder, 0)
    write_pieces(folder / jobs.SCENE, [f"{HEAD}\n{dump(scene)}".encode("utf-8", "surrogateescape")])
    for name, text in files.items():
        write_pieces(folder / name, [text.encode("utf-8", "surrogateescape")])
    again = NEXT[target].format(folder)
    talk.data({"folder": str(folder), "files": [jobs.SCENE, *files], "chunks": list(chunks), "run": again})
    tasks = f"{counted(len(numbers), 'frame')} in {counted(len(chunks), 'task')}"
    talk.note(f"{folder}: {tasks}; start with '{again}'")
