"""report.html of a run: what report.json tells, with the pictures; and of a sweep, a picture a run and the table."""

from __future__ import annotations

import datetime
import urllib.parse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any

from .. import __version__
from ..common.counted import counted
from ..output.files import megabytes, write_pieces
from . import page, pictures

if TYPE_CHECKING:
    pass

FILE = "report.html"
SHEET = 12
"""Frames on the sheet at most."""
SHEET_BYTES, LARGE_BYTES = 480_000, 200_000
"""Of all pictures of the sheet, and of the large one, before they are written as text, which takes a third more."""
PRESET_CHARACTERS = 120_000
MOST_ROWS = 1000
"""Of a sweep's table; the file beside has all."""
MOST_PICTURES, BYTES = 48, 900_000
"""Of a sweep, and of all its pictures."""
ERRORS = {
    "stretch_max": ("stretch", 100.0, " %"), "penetration_max": ("depth of particles in solids", 1000.0, " mm"),
    "segment_penetration_max": ("depth of segments in solids", 1000.0, " mm"),
    "strand_penetration_max": ("depth of strands in strands", 1000.0, " mm"),
    "residual_max": ("residual of the solver", 1.0, ""), "curve_px_max": ("distance from the true curve", 1.0, " px"),
    "follow_stretch_max": ("stretch of followers", 100.0, " %"), "nonfinite": ("strands lost", 1.0, ""),
}  # fmt: skip
"""Of a frame: what it is, factor and unit in which it is shown."""

Json = Mapping[str, Any]


def write(directory: Path, data: Json, preset: str = "", animations: Sequence[Path] = ()) -> Path:
    """Write report.html beside the frames of a run, whole or not at all. ``data``: its report.json; ``preset``: the
    text of all its settings."""
    path = directory / FILE
    write_pieces(path, [page.page(f"{data['preset']['name']}: strandcli", parts(directory, data, preset, animations))])
    return path


def parts(directory: Path, data: Json, preset: str, animations: Sequence[Path]) -> Iterator[str]:
    """The page from top to bottom."""
    frames = [one for one in data.get("frames", []) if isinstance(one, dict) and isinstance(one.get("frame"), int)]
    status = data["status"]
    kind = {"complete": "", "interrupted": "warn"}.get(status, "bad")
    when = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC")
    yield page.header(data["preset"]["name"], status, kind, f"{_span(frames)} · {when} · {directory.resolve().name}")
    yield _trouble(data)
    yield page.section("Pictures", _pictures(directory, frames, animations))
    yield page.section("The run", page.facts(_figures(data, frames)))
    yield page.pair(page.section("Time by stage", _stages(frames)), page.section("Time by frame", _times(frames)))
    errors = [page.section(f"Error by frame: {name}", chart) for name, chart in _errors(frames)]
    yield page.pair(*errors)
    plan = data.get("plan") or {}
    yield page.pair(
        page.section("Left out, and why", _reasons(plan.get("left_out"))),
        page.section("Used, and why", _reasons(plan.get("used"))),
    )
    machine = data.get("machine") or {}
    shown = page.table([(key.replace("_", " "), value) for key, value in machine.items()])
    yield page.pair(page.section("Machine", shown), page.section("Preset", _preset(data, preset)))
    yield page.footer(data["strandcli"])


def _span(frames: Sequence[Json]) -> str:
    numbers = [one["frame"] for one in frames]
    if not numbers:
        return "no frames"
    if len(numbers) == 1:
        return f"frame {numbers[0]}"
    return f"{len(numbers):,} frames, {min(numbers)} to {max(numbers)}"


def _trouble(data: Json) -> str:
    """Why the run ended early, and what it warned of."""
    failure = data.get("failure") or {}
    words = [failure["message"]] if failure.get("message") else []
    return page.section("To know", page.listed([*words, *data.get("warnings", [])]), "note")


def _pictures(directory: Path, frames: Sequence[Json], animations: Sequence[Path]) -> str:
    """The animation, or a large frame, and the sheet."""
    found = [one for one in frames if one.get("file")]
    if not found:
        return ""
    large = next(filter(None, (pictures.film(path) for path in animations if path.suffix != ".mp4")), None)
    if large is None:
        middle = found[len(found) // 2]
        large = pictures.embedded(directory / str(middle["file"]), pictures.LARGE, LARGE_BYTES)
    top = "" if large is None else (
        f'<img class="hero" alt="" width="{large.width}" height="{large.height}" src="{large.address}">'
    )  # fmt: skip
    if len(found) == 1:
        return top
    some = pictures.chosen(found, SHEET)
    cells = [cell(directory / str(one["file"]), f"frame {one['frame']}", SHEET_BYTES // len(some)) for one in some]
    more = f"<p>{len(some)} of {len(found):,} frames</p>" if len(some) < len(found) else ""
    return f'{top}<div class="sheet">{"".join(cells)}</div>{more}'


def cell(path: Path, label: str, most_bytes: int) -> str:
    """A picture of a sheet with its label; the label alone where it cannot be read."""
    one = pictures.embedded(path, pictures.THUMBNAIL, most_bytes)
    image = "" if one is None else (
        f'<img alt="{page.text(label)}" width="{one.width}" height="{one.height}" src="{one.address}">'
    )  # fmt: skip
    return f"<figure>{image}<figcaption>{page.text(label)}</figcaption></figure>"


def _figures(data: Json, frames: Sequence[Json]) -> Iterator[tuple[str, str]]:
    totals = data.get("totals") or {}
    if totals.get("seconds") is not None:
        yield "in all", seconds(totals["seconds"])
    if data.get("compile_seconds"):
        yield "of which compiling, on first use", seconds(data["compile_seconds"])
    fresh = [one["seconds"]["total"] for one in frames if (one.get("seconds") or {}).get("total") is not None]
    if fresh:
        yield "a frame, in the median", seconds(median(fresh))
    if totals.get("peak_rss_bytes"):
        yield "of memory at most", megabytes(totals["peak_rss_bytes"])
    counts = (frames[-1].get("counts") or {}) if frames else {}
    for name in ("strands", "segments", "fragments"):
        if counts.get(name):
            yield name, f"{counts[name]:,}"
    earlier = sum(bool(one.get("kept")) for one in frames)
    if earlier:
        yield "frames of earlier runs", f"{earlier:,}"


def seconds(value: float) -> str:
    """A time for people."""
    if value < 1:
        return f"{1000 * value:.3g} ms"
    return f"{value:.1f} s" if value < 60 else f"{int(value // 60)}:{int(value % 60):02d} min"


def _stages(frames: Sequence[Json]) -> str:
    """A bar a stage: its median over the frames, longest first."""
    by_stage: dict[str, list[float]] = {}
    for one in frames:
        for stage, value in (one.get("seconds") or {}).items():
            if value is not None and stage != "total":
                by_stage.setdefault(stage, []).append(value)
    found = sorted(((stage, median(values)) for stage, values in by_stage.items()), key=lambda pair: -pair[1])
    whole = sum(value for _, value in found) or 1.0
    return page.bars([(stage, value, f"{seconds(value)} · {100 * value / whole:.0f} %") for stage, value in found])


def _times(frames: Sequence[Json]) -> str:
    points = [(one["frame"], one["seconds"]["total"]) for one in frames if (one.get("seconds") or {}).get("total")]
    large = max((value for _, value in points), default=0.0) >= 1
    return page.line([(x, y if large else 1000 * y) for x, y in points], " s" if large else " ms")


def _errors(frames: Sequence[Json]) -> Iterator[tuple[str, str]]:
    """What each error is, and its line."""
    for key, (name, factor, unit) in ERRORS.items():
        points = [(one["frame"], factor * one["error"][key]) for one in frames
                  if (one.get("error") or {}).get(key) is not None]  # fmt: skip
        if any(value > 0 for _, value in points):
            yield name, page.line(points, unit)


def _reasons(stages: Sequence[Json] | None) -> str:
    return page.table([(one["stage"], one["why"]) for one in stages or ()])


def _preset(data: Json, preset: str) -> str:
    rows = [("name", data["preset"]["name"])]
    if data["preset"].get("sha256"):
        rows.append(("SHA-256 of its files", data["preset"]["sha256"]))
    if data.get("scene"):
        rows.append(("fingerprint of what changes pixels", data["scene"]))
    whole = preset[:PRESET_CHARACTERS] + ("\n..." if len(preset) > PRESET_CHARACTERS else "")
    shown = page.folded("every setting, as it was drawn", f"<pre>{page.lines(whole)}</pre>") if preset else ""
    return page.table(rows) + shown


def write_sweep(
    folder: Path, name: str, entries: Sequence[Mapping[str, Any]], head: Sequence[str], rows: Sequence[Sequence[Any]]
) -> Path:
    """Write the page beside the points' folders, whole or not at all. ``entries``: a mapping a point; ``head`` and
    ``rows``: the table."""
    failed = [one for one in entries if one["status"] != "complete"]
    axes = " × ".join(f"{key} ({len({one['settings'][key] for one in entries})})" for key in entries[0]["settings"])
    drawn = pictures.chosen([one for one in entries if one["last_frame"]], MOST_PICTURES)
    cells = [_cell(folder, one, BYTES // len(drawn)) for one in drawn]
    more = f"<p>{len(drawn)} of {counted(len(entries), 'run')}</p>" if len(drawn) < len(entries) else ""
    shown = [one not in ("folder", "last_frame", "pixels_sha256") for one in head]
    table = [[value for value, keep in zip(row, shown, strict=True) if keep] for row in rows[:MOST_ROWS]]
    heads = [one for one, keep in zip(head, shown, strict=True) if keep]
    numbers = [i for i in range(len(heads)) if all(_is_number(row[i]) for row in table)]
    path = folder / FILE
    write_pieces(path, [page.page(f"{name}, a sweep: strandcli", [
        page.header(f"{name}, a sweep", f"{len(failed)} went wrong" if failed else "complete",
                    "bad" if failed else "", f"{counted(len(entries), 'run')} · {axes}"),
        page.section("Last frames", f'<div class="sheet">{"".join(cells)}</div>{more}' if cells else ""),
        page.section("Table", page.table(table, [one.replace("_", " ") for one in heads], numbers)),
        page.footer(__version__),
    ])])  # fmt: skip
    return path


def _cell(folder: Path, entry: Mapping[str, Any], most_bytes: int) -> str:
    """A picture that leads to the page of its run."""
    words = ", ".join(f"{key} = {value}" for key, value in entry["settings"].items())
    inner = cell(folder / entry["folder"] / entry["last_frame"], words, most_bytes)
    return f'<a href="{page.text(urllib.parse.quote(entry["folder"]))}/{FILE}">{inner}</a>'


def _is_number(value: Any) -> bool:
    try:
        float(value)
    except (TypeError, ValueError):
        return value == ""
    return True
