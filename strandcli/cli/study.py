"""`strandcli study`: error against run time, for a preset or against exact solutions."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import MismatchError, UsageError
from . import completion, options
from .progress import Talk
from .values import ERROR, count, metres, several, step, word

if TYPE_CHECKING:
    from ..study.sweep import Experiment, Request, Study

ROOM = 1_000_000
"""Bytes that there has to be room for."""
KINDS = ("csv", "json", "svg")
"""Files of a study."""

max_error = click.option("--max-error", type=ERROR, metavar="ERROR", help="Error to stay under: 1% or 0.01.")


@click.command()
@click.argument("preset", required=False, shell_complete=completion.presets)
@click.option("--reference", type=several("NAMES", word, "elastica,beam"), metavar="NAMES",
              help="Exact solutions in place of a preset: elastica, beam, swing, spring, incline, layer, tuft, "
              "or all.")  # fmt: skip
@click.option("--axis", metavar="NAME", help="What to study of a preset: motion, or of pictures coverage, shadow, "
              "quality.  [default: motion]")  # fmt: skip
@max_error
@click.option("--solver", "solvers", type=several("NAMES", word, "rod,thesis"), metavar="NAMES",
              help="Solvers: thesis, rod.  [default: all]")  # fmt: skip
@click.option("--dt", "steps", type=several("SECONDS", step, "1/24,1/240"), metavar="SECONDS", help="Steps to try.")
@click.option("--substeps", type=several("COUNTS", count(1, 1000), "1,2,4"), metavar="COUNTS",
              help="Steps a frame to try.")  # fmt: skip
@click.option("--iterations", type=several("COUNTS", count(1, 1000), "2,8"), metavar="COUNTS",
              help="Iterations a step to try, of solvers that have them.")  # fmt: skip
@click.option("--particles", type=several("COUNTS", count(2, 10_000), "8,16"), metavar="COUNTS",
              help="Particles a strand to try.")  # fmt: skip
@click.option("--cells", type=several("METRES", metres, "0.01,0.02"), metavar="METRES",
              help="Cells of the rule interaction to try.  [default: the preset's own]")  # fmt: skip
@click.option("--strands", type=options.COUNT_STRANDS, metavar="N",
              help="Strands of the preset: the first N.  [default: 256; shadow: 2000]")  # fmt: skip
@click.option("--span", type=click.FloatRange(1e-3, 3600), metavar="SECONDS",
              help="Part of the preset's film to run, after its pre-roll.  [default: 1]")  # fmt: skip
@click.option("--frame", type=options.Whole(1), metavar="N", help="Frame to draw, of pictures.  [default: 1]")
@click.option("--size", type=options.SIZE, help="Size of pictures.  [default: some 30,000 pixels]")
@options.seed
@options.overrides
@options.folder("out/study")
@options.count_of_threads(default=1, show_default=True,
              help="Threads. One gives the steadiest times, and so few strands hardly need more.")  # fmt: skip
@options.overwrite
@options.talk("Print a line a run on a terminal too, and what is compiled.")
def command(
    preset: str | None, reference: tuple[str, ...] | None, axis: str | None, max_error: float | None,
    output: Path | None, threads: int, overwrite: bool, talk: Talk, **wishes: Any,
) -> None:  # fmt: skip
    """Measure error against run time: of motion over solvers, steps, iterations, particles and cells; of pictures over
    the settings of one stage of drawing, or of all.

    Of PRESET: where strands are, against the limit of finer settings; with --axis, one frame in linear light against a
    far finer one, or rays. With --reference: against exact solutions. Prints a table, writes NAME.csv, .json and .svg,
    and recommends the cheapest setting under an error. A solver that cannot represent something is listed as
    such. Exit code 3: no setting stays under --max-error.
    """
    options.exclusive(dt=bool(wishes["steps"]), substeps=bool(wishes["substeps"]))
    from ..study import find

    chosen = find("reference" if preset is None else "motion" if axis is None else axis)
    requests = _requests(preset, reference, axis, chosen, wishes)
    folder = output or Path("out", "study")
    for request in requests:
        for kind in KINDS:
            options.refuse_existing(folder / f"{file_name(request.name, axis)}.{kind}", overwrite)

    from ..output.files import require_folder
    from ..output.report import finite
    from ..study import report, sweep

    require_folder(folder, ROOM)
    studies = []
    with talk.compiled(1, "study", threads, each="run", lines=True) as progress:
        for request in requests:
            progress.label = f"study {request.name}"
            study = sweep.run(chosen, request, max_error, progress.checked_step, progress.begin)
            studies.append(study)
            _write(study, folder, max_error)
    data = [one.as_dict() for one in studies]
    talk.result(
        finite(data[0] if len(data) == 1 else {"studies": data}), lambda: "\n\n".join(map(report.to_text, studies))
    )
    names = ", ".join(file_name(one.name, one.axis) for one in studies)
    talk.note(f"{folder}: {names} ({', '.join('.' + kind for kind in KINDS)})")
    missed = [one for one in studies if one.points and not one.recommended]
    if max_error is not None and missed:
        raise MismatchError(report.why_missed(missed, max_error))


def _requests(
    preset: str | None, reference: tuple[str, ...] | None, axis: str | None, chosen: type[Experiment],
    wishes: dict[str, Any],
) -> list[Request]:  # fmt: skip
    from ..study.sweep import Request, chosen_solvers

    overrides, seed = wishes.pop("overrides"), wishes.pop("seed")
    if (preset is None) == (reference is None):
        raise UsageError("study takes either a PRESET or --reference NAMES")
    if reference is not None:
        given = {"axis": axis, "seed": seed, "set": overrides or None}
        given |= {name: wishes.pop(name) for name in ("strands", "span", "frame", "size", "cells")}
        for option, value in given.items():
            if value is not None:
                raise UsageError(f"--{option} is for presets; a --reference has its own scene")
        from ..scene.faults import hint
        from ..study.references import REFERENCES

        names = tuple(REFERENCES) if "all" in reference else reference
        for name in names:
            if name not in REFERENCES:
                raise UsageError(f"no reference '{name}'; {hint(name, (*REFERENCES, 'all'), 'they are')}")
        requests = [Request(name=name, **wishes) for name in names]
    else:
        assert preset is not None
        if chosen.axis == "reference":
            raise UsageError(f"axis {axis}: studies no preset; leave out --axis and name a --reference")
        _refuse_foreign(chosen, wishes)
        frame = wishes.pop("frame")
        scene = options.load_scene(preset, seed=seed, overrides=overrides)
        paths = [text.partition("=")[0].strip() for text in overrides]
        wishes |= {"frame": frame or 1, "fixed": frozenset(paths)}
        requests = [Request(scene=scene, name=options.preset_name(preset), **wishes)]
    chosen_solvers(requests[0])
    return requests


MOVED = {"solvers": "--solver", "steps": "--dt", "substeps": "--substeps", "iterations": "--iterations",
         "particles": "--particles", "cells": "--cells", "span": "--span"}  # fmt: skip
DRAWN = {"frame": "--frame", "size": "--size"}
"""Options of motion and of pictures."""


def _refuse_foreign(axis: type[Experiment], wishes: dict[str, Any]) -> None:
    """Raise `UsageError` for options of the other kind of axis."""
    hint = "use --set for the preset's own settings" if axis.draws else "name an --axis of pictures with it"
    for name, option in (MOVED if axis.draws else DRAWN).items():
        if wishes.get(name) is not None:
            raise UsageError(f"{option} does not go with axis {axis.axis}; {hint}")


def file_name(name: str, axis: str | None = None) -> str:
    """A subject's name as that of a file, with the axis where that is one of pictures."""
    if axis not in (None, "motion", "reference"):
        name = f"{name}-{axis}"
    letters = 0 if sys.getfilesystemencoding() == "utf-8" else re.ASCII
    return re.sub(r"[^\w.-]+", "-", name, flags=letters).strip("-.") or "study"


def _write(study: Study, folder: Path, max_error: float | None) -> None:
    from ..compiling import runtime
    from ..output.files import prepare_folder, write_json, write_pieces
    from ..output.report import finite
    from ..study.chart import chart
    from ..study.report import to_csv

    prepare_folder(folder, ROOM)
    name = file_name(study.name, study.axis)
    write_pieces(folder / f"{name}.csv", [to_csv(study).encode()])
    write_pieces(folder / f"{name}.svg", [chart(study, max_error).encode()])
    write_json(folder / f"{name}.json", finite({**study.as_dict(), "machine": runtime.machine()}))
