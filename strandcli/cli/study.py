"""`strandcli study`: error against run time, for a preset or against exact solutions."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import MismatchError, UsageError
from . import options, signals
from .progress import Progress

if TYPE_CHECKING:
    from ..study.axes import Axis, Request
    from ..study.sweep import Study


class ErrorType(click.ParamType):
    """An error as a share: ``1%`` or ``0.01``."""

    name = "ERROR"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        if isinstance(value, float):
            return value
        match = re.fullmatch(r"\s*([0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]{1,3})?)\s*(%?)\s*", str(value), re.ASCII)
        if match is None:
            self.fail(f"'{value}' is not an error, such as 1% or 0.01", param, ctx)
        share = float(match[1]) / (100 if match[2] else 1)
        if not (math.isfinite(share) and 0 < share <= 1):
            self.fail(f"'{value}': an error is more than 0 and at most 100%", param, ctx)
        return share


class ListType(click.ParamType):
    """Values separated by commas."""

    def __init__(self, name: str, read: Callable[[str], Any], example: str) -> None:
        self.name, self.read, self.example = name, read, example

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[Any, ...]:
        if isinstance(value, tuple):
            return value
        found = []
        for word in str(value).split(","):
            try:
                found.append(self.read(word.strip()))
            except ValueError as error:
                self.fail(f"{error}; write for instance {self.example}", param, ctx)
        return tuple(dict.fromkeys(found))


def count(low: int, high: int) -> Callable[[str], int]:
    """A reader of whole numbers in a range."""

    def read(word: str) -> int:
        if not re.fullmatch(r"[0-9]{1,9}", word, re.ASCII) or not low <= int(word) <= high:
            raise ValueError(f"'{word}' is not a whole number from {low} to {high}")
        return int(word)

    return read


def step(word: str) -> float:
    """A step in seconds: ``1/240`` or ``0.01``."""
    match = re.fullmatch(r"([0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]{1,3})?)(?:/([0-9]*\.?[0-9]+))?", word, re.ASCII)
    below = float(match[2]) if match and match[2] else 1.0
    seconds = float(match[1]) / below if match and below > 0 else math.nan
    if not (math.isfinite(seconds) and 1e-6 <= seconds <= 10):
        raise ValueError(f"'{word}' is not a step from 1e-6 to 10 seconds")
    return seconds


def integrator(text: str) -> str:
    """The name of an integrator."""
    if text not in ("euler", "bdf2"):
        raise ValueError(f"'{text}' is not an integrator; they are euler and bdf2")
    return text


def word(text: str) -> str:
    """A name."""
    if not text:
        raise ValueError("an empty name")
    return text


max_error = click.option(
    "--max-error", type=ErrorType(), metavar="ERROR", help="Error that settings have to keep under: 1% or 0.01."
)


@click.command()
@click.argument("preset", required=False)
@click.option("--reference", type=ListType("NAMES", word, "elastica,beam"), metavar="NAMES",
              help="Exact solutions in place of a preset: elastica, tip_load, buckling, beam, chain, catenary, "
              "pendulum, twist, or all.")  # fmt: skip
@click.option("--axis", metavar="NAME", help="What to study of a preset: motion, or of pictures curves, coverage, "
              "shadow, occlusion, lod, tables, end-to-end.  [default: motion]")  # fmt: skip
@max_error
@click.option("--solver", "solvers", type=ListType("NAMES", word, "rod,foil"), metavar="NAMES",
              help="Solvers: thesis, rod, foil.  [default: all]")  # fmt: skip
@click.option("--dt", "steps", type=ListType("SECONDS", step, "1/24,1/240"), metavar="SECONDS", help="Steps to try.")
@click.option("--substeps", type=ListType("COUNTS", count(1, 1000), "1,2,4"), metavar="COUNTS",
              help="Steps a frame to try.")  # fmt: skip
@click.option("--iterations", type=ListType("COUNTS", count(1, 1000), "2,8"), metavar="COUNTS",
              help="Iterations a step to try, of solvers that have them.")  # fmt: skip
@click.option("--integrators", type=ListType("NAMES", integrator, "euler,bdf2"), metavar="NAMES",
              help="Integrators to try, of solvers that have them: euler, bdf2.")  # fmt: skip
@click.option("--particles", type=ListType("COUNTS", count(2, 10_000), "8,16"), metavar="COUNTS",
              help="Particles a strand to try.")  # fmt: skip
@click.option("--strands", type=options.COUNT_STRANDS, metavar="N",
              help="Strands of the preset: the first N.  [default: 256; pictures: 2000]")  # fmt: skip
@click.option("--span", type=click.FloatRange(0, 3600, min_open=True), metavar="SECONDS",
              help="Part of the preset's film to run, after its pre-roll.  [default: 1]")  # fmt: skip
@click.option("--frame", type=click.IntRange(1), metavar="N", help="Frame to draw, of pictures.  [default: 1]")
@click.option("--size", type=options.SizeType(), help="Size of pictures.  [default: some 30,000 pixels]")
@options.seed
@options.overrides
@options.folder("out/study")
@click.option("--threads", type=options.ThreadsType(), default=1, show_default=True,
              help="Threads. One alone is timed most evenly, and so few strands hardly need another.")  # fmt: skip
@options.overwrite
@options.talk("Print a line a run on a terminal too, and what is compiled.")
def command(
    preset: str | None,
    reference: tuple[str, ...] | None,
    axis: str | None,
    max_error: float | None,
    output: Path | None,
    threads: int,
    overwrite: bool,
    as_json: bool,
    quiet: bool,
    verbose: bool,
    no_progress: bool,
    **wishes: Any,
) -> None:
    """Measure error against run time: of motion over solvers, steps, iterations and particles; of pictures over the
    knobs of one stage of drawing, or all.

    Of PRESET: where strands are, against the limit of finer settings; with --axis, one frame in linear light against a
    far finer one, or rays, or quadrature. With --reference: against exact solutions; of several also a table with a row
    for each of them and each solver. Prints a table, writes NAME.csv, .json, .png and .svg, and recommends the cheapest
    setting under an error. A solver that cannot represent something
    is told as not represented. Exit code 3: no setting keeps under --max-error.
    """
    options.exclusive(quiet=quiet, verbose=verbose)
    options.exclusive(dt=bool(wishes["steps"]), substeps=bool(wishes["substeps"]))
    from ..study import axes

    requests = _requests(preset, reference, axis, wishes)
    folder = output or Path("out", "study")
    for request in requests:
        options.refuse_existing(folder / f"{file_name(request.name, axis)}.json", overwrite)

    from .. import runtime
    from ..study import summary, sweep

    chosen = axes.find("reference" if preset is None else axis or "motion")
    studies = []
    hidden = no_progress or quiet
    with Progress(1, "study", hidden=hidden, verbose=verbose, each="run", lines=True) as progress:
        runtime.start(threads, progress.note)
        for request in requests:
            progress.label = f"study {request.name}"
            study = sweep.run(chosen, request, max_error, stepper(progress), beginner(progress))
            studies.append(study)
            _write(study, folder, max_error)
    if as_json:
        data = [one.as_dict() for one in studies]
        several = {"studies": data, "summary": summary.rows(studies, max_error)}
        options.print_json(_finite(data[0] if len(data) == 1 else several))
    elif not quiet:
        from ..study.tables import to_text

        texts = [to_text(one) for one in studies]
        if len(studies) > 1:
            texts.append(summary.to_text(summary.rows(studies, max_error)))
        click.echo("\n\n".join(texts))
    if not quiet:
        names = ", ".join(file_name(one.name, one.axis) for one in studies)
        click.echo(f"{folder}: {names} (.csv, .json, .png, .svg)", err=True)
    missed = [one for one in studies if one.offered and not one.recommended]
    if max_error is not None and missed:
        raise MismatchError(_missed(missed, max_error))


def _requests(
    preset: str | None, reference: tuple[str, ...] | None, axis: str | None, wishes: dict[str, Any]
) -> list[Request]:
    from ..study.axes import Request, chosen_solvers, find, settled

    overrides, seed = wishes.pop("overrides"), wishes.pop("seed")
    if (preset is None) == (reference is None):
        raise UsageError("study takes either a PRESET or --reference NAMES")
    if reference is not None:
        given = {"--strands": wishes.pop("strands"), "--span": wishes.pop("span"), "--axis": axis, "--seed": seed}
        given |= {"--set": overrides or None, "--frame": wishes.pop("frame"), "--size": wishes.pop("size")}
        for option, value in given.items():
            if value is not None:
                raise UsageError(f"{option} is for presets; a --reference has its own scene")
        from ..study.references import REFERENCES

        names = tuple(REFERENCES) if "all" in reference else reference
        for name in names:
            if name not in REFERENCES:
                from difflib import get_close_matches

                close = get_close_matches(name, REFERENCES, n=1)
                hint = f"did you mean '{close[0]}'?" if close else f"they are {', '.join(REFERENCES)}, all"
                raise UsageError(f"no reference '{name}'; {hint}")
        requests = [Request(name=name, **wishes) for name in names]
    else:
        assert preset is not None
        chosen = find(axis or "motion")
        if not chosen.of_preset:
            raise UsageError(f"axis {axis}: studies no preset; leave out --axis and name a --reference")
        _refuse_others(chosen, wishes)
        frame = wishes.pop("frame")
        scene = options.load_scene(preset, seed=seed, overrides=overrides)
        paths = [text.partition("=")[0].strip() for text in overrides]
        if not chosen.pictures:
            for name, values in settled(scene, paths).items():  # what is set by hand is not turned
                wishes[name] = wishes[name] or values
        wishes |= {"frame": frame or 1, "fixed": frozenset(paths)}
        requests = [Request(scene=scene, name=options.preset_name(preset), **wishes)]
    chosen_solvers(requests[0])
    return requests


def _refuse_others(axis: Axis, wishes: dict[str, Any]) -> None:
    """Raise `UsageError` for options of motion at an axis of pictures, and the other way round."""
    motion = {"solvers": "--solver", "steps": "--dt", "substeps": "--substeps", "iterations": "--iterations",
              "integrators": "--integrators", "particles": "--particles", "span": "--span"}  # fmt: skip
    foreign = motion if axis.pictures else {"frame": "--frame", "size": "--size"}
    for name, option in foreign.items():
        if wishes.get(name) is not None:
            what = "use --set for the preset's own settings" if axis.pictures else "name an --axis of pictures with it"
            raise UsageError(f"{option} does not go with axis {axis.name}; {what}")


def beginner(progress: Progress) -> Callable[[int], None]:
    """Tells a progress line how many runs there will be."""

    def begin(runs: int) -> None:
        progress.total, progress.done = max(1, runs), 0

    return begin


def stepper(progress: Progress) -> Callable[[str], None]:
    """Tells it of each run; stops here if the user wants so."""

    def step(text: str) -> None:
        progress.step(text)
        signals.check()

    return step


def file_name(name: str, axis: str | None = None) -> str:
    """A subject's name as that of a file, with the axis where that is one of pictures."""
    if axis not in (None, "motion", "reference"):
        name = f"{name}-{axis}"
    return re.sub(r"[^\w.-]+", "-", name).strip("-.") or "study"


def _finite(data: Any) -> Any:
    """Data without NaN and infinities, which JSON does not have: null in their place."""
    from ..output.report import finite

    return finite(data)


def _write(study: Study, folder: Path, max_error: float | None) -> None:
    from .. import runtime
    from ..output.compare import write_image
    from ..output.files import prepare_folder, write_json, write_pieces
    from ..study.chart import chart
    from ..study.tables import to_csv

    prepare_folder(folder, 1_000_000)
    name = file_name(study.name, study.axis)
    drawing = chart(study, max_error)
    write_pieces(folder / f"{name}.csv", [to_csv(study).encode()])
    write_pieces(folder / f"{name}.svg", [drawing.svg().encode()])
    write_image(folder / f"{name}.png", drawing.picture())
    write_json(folder / f"{name}.json", _finite({**study.as_dict(), "machine": runtime.machine()}))


def _missed(studies: list[Study], most: float) -> str:
    """Why nothing could be recommended: how near each solver comes, and what to try."""
    words = [f"{study.name}: {_nearest(study)}" for study in studies]
    return f"no setting keeps under an error of {_share(most)}: {'; '.join(words)}; {_remedy(studies)}"


def _nearest(study: Study) -> str:
    """How near each solver that presets may ask for comes."""
    found = []
    for solver in dict.fromkeys(point.solver for point in study.offered):
        limit = study.reference.get("limits", {}).get(solver)
        if limit is not None and not limit["converges"]:
            gap = limit["gaps"][1]
            moved = f" (its last refinement moved strands by {_share(gap)})" if math.isfinite(gap) else ""
            found.append(f"{solver} has no limit in sight{moved}")
            continue
        errors = [point.error.get(study.metric) for point in study.offered if point.solver == solver]
        known = [error for error in errors if error is not None]
        sure = f", its limit known to {_share(limit['uncertainty'])}" if limit is not None else ""
        found.append(f"{solver} comes to {_share(min(known))}{sure}".strip() if known else f"{solver} has no error")
    return ", ".join(found)


def _remedy(studies: list[Study]) -> str:
    """What to try: first of all segments as short as strands bend."""
    if any(study.axis not in ("motion", "reference") for study in studies):
        return "allow a greater error"
    for study in studies:
        bend = study.reference.get("bend")
        tried = [point.knobs["emitter.particles"] for point in study.offered if "emitter.particles" in point.knobs]
        if bend and tried and bend * (max(tried) - 1) < 1:
            need = math.ceil(1 / bend) + 1
            return (
                f"strands bend within {_share(bend)} of their length, less than a segment: "
                f"try --solver rod --particles {need},{2 * need - 1}"
            )
    return "try finer --substeps or --particles"


def _share(value: float) -> str:
    from ..study.chart import share

    return share(value)
