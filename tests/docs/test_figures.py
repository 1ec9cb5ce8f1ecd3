"""Figures of the pages are those of docs/figures.json, which commands write."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest

from docs import figures as program
from pages import ROOT


@pytest.mark.parametrize("page", program.PAGES, ids=lambda page: page.stem)
def test_pages_have_the_figures_that_commands_wrote(page: Any) -> None:
    text = page.read_text(encoding="utf-8")
    assert program.filled(text, program.definitions(), program.measured()) == text, "run: python docs/figures.py fill"


def test_every_figure_is_of_a_command_and_shown_on_a_page() -> None:
    known, data = program.definitions(), program.measured()
    shown = {(kind, name) for page in program.PAGES for kind, name, _ in program.MARK.findall(page.read_text("utf-8"))}
    assert {name for kind, name in shown if kind == "figure"} == known["figures"].keys()
    assert {name for kind, name in shown if kind == "table"} == known["tables"].keys()
    assert known["commands"].keys() == data.keys()
    for name, one in known["commands"].items():
        assert data[name]["run"] == one["run"], f"{name}: measured by another command: measure it again"


def test_the_readme_and_the_page_on_speed_name_no_speed_of_their_own() -> None:
    """Speeds stand in marks alone, or are the source's."""
    for name in ("README.md", "docs/speed.md"):
        rest = program.MARK.sub("", (ROOT / name).read_text(encoding="utf-8")).replace("25 to 30", "")
        assert not re.findall(r"\d[\d.,]* (?:frames/s|frames a second|ns|ms)\b", rest), name


def test_a_figure_tells_its_spread() -> None:
    known = {"figures": {"speed": {"of": "bench", "at": "frame.fps", "unit": "frames/s"}}}
    steady = {"bench": {"runs": [{"frame": {"fps": fps}} for fps in (50.0, 51.0, 52.0)]}}
    wide = {"bench": {"runs": [{"frame": {"fps": fps}} for fps in (64.0, 40.0, 52.0)]}}
    page = "a <!-- figure speed -->old<!-- end --> b"
    assert program.filled(page, known, steady) == "a <!-- figure speed -->51 frames/s<!-- end --> b"
    assert program.filled(page, known, wide) == "a <!-- figure speed -->40 to 64 frames/s<!-- end --> b"
    with pytest.raises(KeyError):
        program.filled(page.replace("speed", "none"), known, wide)


@pytest.mark.parametrize(
    ("value", "text"), [(0.0456, ".046"), (12345.0, "12,300"), (1.04, "1.04"), (-0.5, "-.5"), (0.0, "0"), (99.6, "100")]
)
def test_numbers_have_two_digits(value: float, text: str) -> None:
    assert program.number(value) == text


def test_of_a_study_rods_alone_are_kept() -> None:
    def point(solver: str, particles: int, error: float) -> dict[str, Any]:
        return {"parameters": {"solver": solver, "emitter.particles": particles}, "error": {"tip": error}}

    points = [point("rod", 6, 0.1), point("rod", 6, 0.05), point("rod", 11, 0.02), point("foil", 6, 0.001)]
    lines = (("rod", "segment", 1.9), ("rod", "dt", None), ("foil", "segment", 3.0))
    orders = [{"line": line, "metric": "tip", "in": axis, "order": order} for line, axis, order in lines]
    study = {"name": "elastica", "title": "t", "unit": "of L", "metric": "tip", "points": points, "orders": orders}
    (found,) = program.kept_of_study({"studies": [study]})["studies"]
    assert found["errors"] == [(5, 0.05), (10, 0.02)]
    assert found["orders"] == [1.9, None]
    assert json.loads(json.dumps(found))
