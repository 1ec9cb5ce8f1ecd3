"""`strandcli render --sweep`: one run for each combination of values, a table, a sheet and a page of all."""

from __future__ import annotations

import csv
import hashlib
import io
import itertools
import math
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import click

from ..common.counted import counted
from ..errors import SimulationError, UsageError
from ..scene.faults import SceneError
from . import completion, options, signals
from .progress import print_json, say
from .values import Parsed, stepped

TABLE, SHEET = "sweep.csv", "sweep.png"
COLUMNS, WIDTH, MOST_CELLS = 4, 320, 400
"""Of the sheet: pictures a row, their width, and how many at most."""


def run(draw: Callable[..., None], given: Mapping[str, Any]) -> None:
    """Draw every point with ``draw``, the command itself, whose arguments are ``given``.

    A point that goes wrong is reported in the table, and the rest go on; then the whole ends as that one did.
    """
    from ..output.files import prepare_folder, write_pieces

    settings = dict(given)
    try:
        wanted = points(settings.pop("sweep"))
    except ValueError as error:
        raise UsageError(str(error)) from None
    output = settings.pop("output")
    folder = output or options.default_folder(f"{options.preset_name(settings['preset'])}-sweep")
    _check(wanted, folder, settings)
    entries: list[dict[str, Any]] = []
    failed: list[SimulationError] = []
    for place, point in enumerate(wanted, 1):
        if not settings["quiet"]:
            say(f"{place}/{len(wanted)} {', '.join(point.overrides())}", err=True)
        one = {**settings, "sweep": (), "output": folder / point.name, "as_json": False, "quiet": True,
               "verbose": False, "overrides": (*settings["overrides"], *point.overrides())}  # fmt: skip
        try:
            draw(**one)
        except SimulationError as error:
            failed.append(error)
            if not settings["quiet"]:
                say(f"{point.name}: {error}", err=True)
        entries.append(_entry(point, folder))
        prepare_folder(folder, 0)
        write_pieces(folder / TABLE, [to_csv(entries).encode("utf-8", "backslashreplace")])
        signals.check()
    made = _finish(folder, settings, entries)
    if settings["as_json"]:
        print_json({"folder": str(folder), "points": entries})
    if not settings["quiet"]:
        bad = f", {len(failed)} of which went wrong" if failed else ""
        say(f"{folder}: {counted(len(entries), 'run')}{bad}; {', '.join(made)}", err=True)
    if failed:
        raise failed[0]


def _check(wanted: Sequence[Point], folder: Path, settings: Mapping[str, Any]) -> None:
    """Load every point's scene, so that a wrong value is reported before the first is drawn."""
    if not (settings["overwrite"] or settings["resume"]) and (folder / TABLE).exists():
        raise UsageError(f"{folder}: holds {TABLE} already; add --overwrite to replace or --resume to continue")
    names = ("size", "strands", "particles", "seed", "quality")
    own = {name: settings[name] for name in names}
    for point in wanted:
        overrides = (*settings["overrides"], *point.overrides())
        try:
            scene = options.load_scene(settings["preset"], **own, overrides=overrides)
        except SceneError as error:
            own = {f"--set {text}": f"--sweep {text}" for text in point.overrides()}
            raise SceneError(replace(fault, file=own.get(fault.file, fault.file)) for fault in error.faults) from None
        options.frame_numbers(settings["frames"], scene, settings["from_cache"])


def _entry(point: Point, folder: Path) -> dict[str, Any]:
    """What the report of a point says, for the table."""
    from statistics import median

    from ..output.report import read_report

    data = read_report(folder / point.name) or {}
    frames = [one for one in data.get("frames", []) if isinstance(one, dict)]
    seconds = [one["seconds"]["total"] for one in frames if (one.get("seconds") or {}).get("total") is not None]
    errors: dict[str, float] = {}
    for one in frames:
        for name, value in (one.get("error") or {}).items():
            if value is not None:
                errors[name] = max(value, errors.get(name, value))
    return {
        "folder": point.name, "settings": dict(point.settings), "status": data.get("status", "failed"),
        "frames": len(frames), "seconds_a_frame": median(seconds) if seconds else None,
        "last_frame": frames[-1].get("file") if frames else None,
        "pixels_sha256": frames[-1].get("pixels_sha256") if frames else None, "error": errors,
    }  # fmt: skip


def to_csv(entries: Sequence[Mapping[str, Any]]) -> str:
    """A row a point: its folder, its settings, and what its report says."""
    head, rows = rows_of(entries)
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows([head, *rows])
    return out.getvalue()


def rows_of(entries: Sequence[Mapping[str, Any]]) -> tuple[list[str], list[list[Any]]]:
    """The table's head and rows."""
    keys = list(entries[0]["settings"])
    errors = list(dict.fromkeys(name for one in entries for name in one["error"]))
    head = ["folder", *keys, "status", "frames", "seconds_a_frame", *errors, "last_frame", "pixels_sha256"]
    rows = [
        [one["folder"], *one["settings"].values(), one["status"], one["frames"], _number(one["seconds_a_frame"]),
         *(_number(one["error"].get(name)) for name in errors), one["last_frame"] or "", one["pixels_sha256"] or ""]
        for one in entries
    ]  # fmt: skip
    return head, rows


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.6g}"


def _finish(folder: Path, settings: Mapping[str, Any], entries: Sequence[Mapping[str, Any]]) -> list[str]:
    """Write sheet and page; returns the names of all that stands beside the points' folders."""
    from ..output.sheet import Cell, write_sheet

    made = [TABLE]
    cells = [
        Cell(folder / one["folder"] / one["last_frame"], ", ".join(f"{k}={v}" for k, v in one["settings"].items()))
        for one in entries
        if one["last_frame"]
    ][:MOST_CELLS]
    if cells:
        write_sheet(folder / SHEET, cells, min(COLUMNS, len(cells)), WIDTH)
        made.append(SHEET)
    if not settings["no_html"]:
        from ..html_report.run import FILE, write_sweep

        write_sweep(folder, options.preset_name(settings["preset"]), entries, *rows_of(entries))
        made.append(FILE)
    return made


MOST_POINTS = 10_000
LONGEST_VALUE, LONGEST_NAME = 24, 100
RANGE = re.compile(r"(-?[0-9]{1,9})-([0-9]{1,9})(?:x([0-9]{1,9}))?")


class Axis(NamedTuple):
    """A setting, by its dotted path, and the values that it takes, as `--set` has them."""

    key: str
    values: tuple[str, ...]


class Point(NamedTuple):
    """One combination: ``settings`` of each axis, KEY=VALUE, and the name of its folder."""

    name: str
    settings: tuple[tuple[str, str], ...]

    def overrides(self) -> tuple[str, ...]:
        """The settings as after --set."""
        return tuple(f"{key}={value}" for key, value in self.settings)


def axis_of(text: str) -> Axis:
    """``wind.strength=1,2,4`` or ``seed=1-8`` or ``seed=1-9x2``; commas in brackets and quotes belong to a value.
    Raises ``ValueError``."""
    key, given, after = text.partition("=")
    if not given or not re.fullmatch(r"\s*[^\s=]+\s*", key):
        raise ValueError(f"'{text}' is not KEY=VALUES, such as wind.strength=1,2,4 or seed=1-8")
    values = []
    for word in split(after):
        if not word:
            raise ValueError(f"'{text}': a value is empty; write for instance {key.strip()}=1,2,4")
        try:
            values += numbers(word)
        except ValueError as error:
            raise ValueError(f"'{text}': {error}") from None
        if len(values) > MOST_POINTS:
            raise ValueError(f"'{text}': more than {MOST_POINTS:,} values")
    return Axis(key.strip(), tuple(dict.fromkeys(values)))


def split(text: str) -> list[str]:
    """Words between commas, where these are in no brackets and no quotes."""
    found, depth, quote, word = [], 0, "", ""
    for c in text:
        if quote:
            quote = "" if c == quote else quote
        elif c in "\"'":
            quote = c
        elif c in "[{(":
            depth += 1
        elif c in "]})":
            depth -= 1
        elif c == "," and depth <= 0:
            found.append(word.strip())
            word = ""
            continue
        word += c
    return [*found, word.strip()]


def numbers(word: str) -> list[str]:
    """The whole numbers of a range, ``1-8`` or ``1-9x2``; anything else alone. Raises ``ValueError``."""
    match = RANGE.fullmatch(word)
    if match is None:
        return [word]
    found = stepped(word, int(match[1]), int(match[2]), int(match[3] or 1))
    if len(found) > MOST_POINTS:
        raise ValueError(f"{word}: more than {MOST_POINTS:,} values")
    return [str(number) for number in found]


def points(axes: Sequence[Axis]) -> list[Point]:
    """All combinations, the last axis varying fastest. Raises ``ValueError`` for too many, or a setting given twice.

    Their folders' names say what is different and are taken by every file system, with a hash of the settings where
    they do not say all.
    """
    keys = [axis.key for axis in axes]
    if twice := [key for key in keys if keys.count(key) > 1]:
        raise ValueError(f"--sweep {twice[0]}=...: is given twice; write all its values after one")
    count = math.prod(len(axis.values) for axis in axes)
    if count > MOST_POINTS:
        raise ValueError(f"--sweep: {count:,} combinations; at most {MOST_POINTS:,} are drawn in one go")
    lasts = [key.rpartition(".")[2] for key in keys]
    short = [last if lasts.count(last) == 1 else key for key, last in zip(keys, lasts, strict=True)]
    found = []
    for values in itertools.product(*(axis.values for axis in axes)):
        plain = "-".join(f"{key}_{value}" for key, value in zip(short, values, strict=True))
        parts = (f"{_safe(key)}_{_safe(value)[:LONGEST_VALUE]}" for key, value in zip(short, values, strict=True))
        found.append((plain, "-".join(parts)[:LONGEST_NAME].strip(".-"), tuple(zip(keys, values, strict=True))))
    taken = Counter(name.casefold() for _, name, _ in found)
    return [Point(name if name == plain and taken[name.casefold()] == 1 else _distinct(name, settings), settings)
            for plain, name, settings in found]  # fmt: skip


def _distinct(name: str, settings: tuple[tuple[str, str], ...]) -> str:
    digest = hashlib.sha256(repr(settings).encode("utf-8", "surrogatepass")).hexdigest()[:8]
    return f"{name}-{digest}".lstrip("-")


def _safe(text: str) -> str:
    return re.sub(r"[^\w.+-]+", "-", text, flags=re.ASCII).strip("-")


sweep_option = click.option(
    "--sweep", "sweep", multiple=True, type=Parsed("KEY=VALUES", axis_of), metavar="KEY=VALUES",
    shell_complete=completion.keys,
    help="Draw once for each value, as of wind.strength=1,2,4 or seed=1-8; if repeated, for all combinations.",
)  # fmt: skip
