"""Figures of the documentation: measured by commands, kept in docs/figures.json, and put into the pages from there.

    python docs/figures.py measure [COMMAND ...]   run commands of docs/figures.toml, or all; fill the pages
    python docs/figures.py fill                    fill the pages

A page marks a figure as ``<!-- figure NAME -->text<!-- end -->``, where and when a command was run as
``<!-- machine COMMAND -->text<!-- end -->``, and a table as ``<!-- table NAME -->`` and ``<!-- end -->`` on lines of
their own. What stands between is written by this program alone, so no two pages disagree.
Measure speed on a machine that does nothing else.
"""

from __future__ import annotations

import json
import os
import platform
import re
import shlex
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable, Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
PAGES = (HERE.parent / "README.md", *sorted(HERE.glob("*.md")))
MARK = re.compile(r"<!-- (figure|machine|table) (\S+) -->(.*?)<!-- end -->", re.DOTALL)
SPREAD = 1.05
"""Runs whose largest figure is more than so many times the least are told as a range."""


def definitions() -> dict[str, Any]:
    """docs/figures.toml: ``commands`` (``run``, ``times``, and how JSON is cut down, ``keep``) and ``figures`` (``of``,
    a command; ``at``, a path in what is kept; ``unit``, ``times``, a factor)."""
    return tomllib.loads((HERE / "figures.toml").read_text(encoding="utf-8"))


def measured() -> dict[str, Any]:
    """docs/figures.json: of each command its ``runs``, ``machine`` and ``date``."""
    found: dict[str, Any] = json.loads((HERE / "figures.json").read_text(encoding="utf-8"))
    return found


def value_at(data: Any, path: str) -> Any:
    """What stands in JSON data at a dotted path."""
    for part in path.split("."):
        data = data[int(part) if isinstance(data, list) else part]
    return data


def number(value: float) -> str:
    """A number in two digits, three if it begins with 1; without a 0 before the point."""
    digits = 3 if f"{abs(value):e}".startswith("1") else 2
    text = f"{float(f'{value:.{digits}g}'):,.10f}".rstrip("0").rstrip(".")
    return re.sub(r"^(-?)0\.", r"\1.", text)


def text_of(values: Sequence[float], unit: str) -> str:
    """The least and the largest of some runs, or one number where they hardly differ."""
    low, high = number(min(values)), number(max(values))
    same = low == high or max(values) <= SPREAD * min(values)
    return f"{number(sorted(values)[len(values) // 2])} {unit}" if same else f"{low} to {high} {unit}"


def figure(name: str, known: Mapping[str, Any], data: Mapping[str, Any]) -> str:
    """The text of a figure by name."""
    one = known["figures"][name]
    factor = one.get("times", 1.0)
    return text_of([factor * value_at(run, one["at"]) for run in data[one["of"]]["runs"]], one["unit"]).strip()


def where(name: str, known: Mapping[str, Any], data: Mapping[str, Any]) -> str:
    """The machine on which a command was run, and the month."""
    return f"{data[name]['machine']}, {data[name]['date']}"


def row(cells: Sequence[str]) -> str:
    """A row of a table."""
    return f"| {' | '.join(cells)} |"


def table(name: str, known: Mapping[str, Any], data: Mapping[str, Any]) -> str:
    """The text of a table by name: a function of this module, handed what its commands found."""
    one = known["tables"][name]
    rows = TABLES[one["rows"]]({each: data[each]["runs"][0] for each in one["of"]})
    head, *rest = [row(cells) for cells in rows]
    return "\n".join(["\n", head, "|" + "---|" * len(rows[0]), *rest, "\n"])


def references(found: Mapping[str, Any]) -> list[list[str]]:
    """A row an exact solution: the least error of rods at each number of segments, over steps, and the orders."""
    rows = [["exact solution", "of what", "segments: least error over steps", "order in the segment, in the step"]]
    for study in (study for one in found.values() for study in one["studies"]):
        errors = ", ".join(f"{count}: {percent(error)}" for count, error in study["errors"])
        orders = [number(each) if each is not None else "–" for each in study["orders"]]
        rows.append([f"`{study['name']}`: {study['title']}", study["unit"], errors, ", ".join(orders)])
    return rows


def axes(found: Mapping[str, Any]) -> list[list[str]]:
    """A row an axis: the settings on the front of error and time, with the errors."""
    rows = [["axis", "error", "settings"]]
    for one in found.values():
        told = "; ".join(f"{settings}: {percent(error)}" for settings, error in one["front"])
        rows.append([f"`{one['axis']}`", f"{one['metric']}, {one['unit']}", told])
    return rows


def percent(error: float) -> str:
    """A share in per cent."""
    return f"{number(100 * error)} %"


def stages(found: Mapping[str, Any]) -> list[list[str]]:
    """A row a stage, a column a preset: milliseconds."""
    names = list(dict.fromkeys(stage for one in found.values() for stage in one["stages"]))
    rows = [["stage", *(f"`{one['preset']}`" for one in found.values())]]
    for name in names:
        cells = [one["stages"].get(name) for one in found.values()]
        rows.append([name, *(f"{number(cell['median_ms'])} ms" if cell else "–" for cell in cells)])
    return [*rows, ["frame", *(f"{number(one['frame']['median_ms'])} ms" for one in found.values())]]


def qualities(found: Mapping[str, Any]) -> list[list[str]]:
    """A row a quality, a column a preset: error, ꟻLIP, seconds of the processor."""
    rows = [["quality", *(f"`{one['name']}`" for one in found.values())]]
    for quality in next(iter(found.values()))["qualities"]:
        cells = [one["qualities"][quality] for one in found.values()]
        rows.append([quality, *(f"{percent(c['rmse'])}, {number(c['flip'])}, {number(c['seconds'])} s" for c in cells)])
    return rows


def pictures(found: Mapping[str, Any]) -> list[list[str]]:
    """A row a preset, a column a setting: error and brightness beside the path tracer."""
    shots = [shot for one in found.values() for shot in one["shots"]]
    names = list(dict.fromkeys(name for shot in shots for name in shot["pictures"]))
    rows = [["frame", "strands", *names]]
    for shot in shots:
        cells = [shot["pictures"].get(name) for name in names]
        told = ["–" if c is None else f"{c['rmse']:.3f} ± {c['sure']:.3f}, {c['brightness']:.3f}" for c in cells]
        rows.append([f"`{shot['preset']}`, {shot['frame']}", f"{shot['strands']:,}", *told])
    return rows


TABLES: dict[str, Callable[[Mapping[str, Any]], list[list[str]]]] = {
    one.__name__: one for one in (references, axes, stages, qualities, pictures)
}


def filled(text: str, known: Mapping[str, Any], data: Mapping[str, Any]) -> str:
    """A page's text with its marks filled. Raises `KeyError` for a name that is not defined or not measured."""
    makers = {"figure": figure, "machine": where, "table": table}

    def one(found: re.Match[str]) -> str:
        kind, name, _ = found.groups()
        return f"<!-- {kind} {name} -->{makers[kind](name, known, data)}<!-- end -->"

    return MARK.sub(one, text)


def kept_of_study(data: Any) -> Any:
    """Of a study of references: of rods the least error of each number of segments, and the orders of the metric."""
    studies = []
    for study in data["studies"]:
        metric, least = study["metric"], {}
        for point in study["points"]:
            parameters, error = point["parameters"], point["error"].get(metric)
            if parameters["solver"] != "rod" or error is None:
                continue
            count = parameters.get("emitter.particles", 1) - 1
            least[count] = min(error, least.get(count, error))
        line = max((one["line"] for one in study["orders"] if one["line"].startswith("rod")), default="", key=better)
        orders = {one["in"]: one["order"] for one in study["orders"] if (one["line"], one["metric"]) == (line, metric)}
        told = {key: study[key] for key in ("name", "title", "unit")}
        studies.append({**told, "errors": sorted(least.items()), "orders": [orders.get("segment"), orders.get("dt")]})
    return {"studies": studies}


def better(line: str) -> bool:
    """Whether a line of a study is of BDF2."""
    return "bdf2" in line


def kept_of_quality(data: Any) -> Any:
    """Of a study of qualities the points with names."""
    named = {one["parameters"]["quality"]: one for one in data["points"] if "quality" in one["parameters"]}
    finest = {"image.supersample": 6, "curves.tolerance": 0.1}
    for one in data["points"]:
        if finest.items() <= one["parameters"].items():
            named["6 × 6 samples, curves within 1/10 sample"] = one
    of = {name: {**one["error"], "seconds": one["seconds"]} for name, one in named.items()}
    return {"name": data["name"], "title": data["title"], "qualities": of}


def kept_of_axis(data: Any) -> Any:
    """Of a study of one axis the settings of which none is both faster and nearer, from the fastest on."""
    front = [one for one in data["points"] if one["pareto"] and one["error"].get(data["metric"]) is not None]
    front.sort(key=lambda one: one["seconds"])
    told = [(", ".join(f"{name.rpartition('.')[2]} {value}" for name, value in one["parameters"].items()),
             one["error"][data["metric"]]) for one in front]  # fmt: skip
    return {**{key: data[key] for key in ("axis", "title", "metric", "unit")}, "front": told}


def kept_of_bench(data: Any) -> Any:
    """Of `bench` what pages tell."""
    keys = ("preset", "stages", "frame", "steps", "rules", "lines", "particle_step_ns", "peak_rss_bytes", "exponents")
    return {key: data[key] for key in keys if key in data}


KEEP = {
    "study": kept_of_study,
    "axis": kept_of_axis,
    "quality": kept_of_quality,
    "bench": kept_of_bench,
    "all": lambda data: data,
}


def run(command: Mapping[str, Any]) -> dict[str, Any]:
    """Run a command as often as it says, and return its figures with where and when they were measured."""
    words = [str(Path(sys.executable).parent / "strandcli"), *shlex.split(command["run"])[1:], "--json", "-q"]
    if command["run"].startswith("python "):
        words = [sys.executable, *shlex.split(command["run"])[1:]]
    runs = []
    for _ in range(command.get("runs", 1)):
        with tempfile.TemporaryDirectory() as folder:
            own = ["-o", folder, "--overwrite"] if " study " in f" {command['run']} " else []
            done = subprocess.run([*words, *own], check=True, stdout=subprocess.PIPE, text=True, cwd=HERE.parent)
        runs.append(KEEP[command["keep"]](json.loads(done.stdout)))
    return {"run": command["run"], "runs": runs, "machine": machine(), "date": date.today().isoformat()[:7]}


def machine() -> str:
    """The processor's name and the number of cores."""
    try:
        found = re.search(r"model name\s*: (.+)", Path("/proc/cpuinfo").read_text())
    except OSError:
        found = None
    return f"{os.cpu_count()} cores of {found[1] if found else platform.processor()}"


def main(words: Sequence[str]) -> None:
    """Do what the module's first lines say."""
    known, data = definitions(), measured()
    if words[:1] == ["measure"]:
        for name in words[1:] or known["commands"]:
            print(f"{name}: {known['commands'][name]['run']}", flush=True)
            data[name] = run(known["commands"][name])
            (HERE / "figures.json").write_text(json.dumps(data, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    elif words != ["fill"]:
        sys.exit(__doc__)
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        if (now := filled(text, known, data)) != text:
            page.write_text(now, encoding="utf-8")
            print(f"{page.name}: filled")


if __name__ == "__main__":
    main(sys.argv[1:])
