"""What is drawn and written of a study: its chart, CSV and the table."""

from __future__ import annotations

import csv
import io
import xml.etree.ElementTree as xml

import pytest

from strandcli.study.chart import Scale, chart, styles_of
from strandcli.study.points import Point
from strandcli.study.report import order_words, step, to_csv, to_text
from study_kit import made


def test_csv_holds_all_points() -> None:
    study = made()
    rows = list(csv.DictReader(io.StringIO(to_csv(study))))
    assert len(rows) == 32
    for row, point in zip(rows, study.points, strict=True):
        assert (row["solver"], float(row["dt"])) == (point.solver, point.sizes["dt"])
        assert float(row["tip"]) == point.error["tip"]
        assert row["other"] == ""
        assert row["pareto"] == str(int(point.pareto))


def test_the_table_says_what_there_is_to_say() -> None:
    text = to_text(made(0.1))
    assert "thesis: not represented: inertia" in text
    assert "order 2.00 in Δt" in text
    assert "under 10 %: solver=one" in text
    assert sum(line.startswith("*") for line in text.splitlines()) == sum(point.pareto for point in made().points) + 1


SPACE = "{http://www.w3.org/2000/svg}"


def test_the_chart_shows_every_point_front_and_wish() -> None:
    study = made(0.1)
    root = xml.fromstring(chart(study, 0.1))
    texts = [element.text for element in root.iter(f"{SPACE}text")]
    assert {"a made-up solver", "run time", "asked for: 10 %", "one", "two", "thesis: not represented"} <= set(texts)
    rings = [circle for circle in root.iter(f"{SPACE}circle") if circle.get("r") == "9"]
    assert len(rings) == sum(point.pareto for point in study.points)
    stars = [one for one in root.iter(f"{SPACE}polygon") if one.get("fill") == "#f2b705"]
    assert len(stars) == len(study.recommended)


def test_no_two_lines_of_a_chart_look_the_same() -> None:
    names = ["thesis", "rod", *"abcdefghijkl"]
    styles = styles_of([Point({}, 1.0, {}, name) for name in names])
    assert list(styles) == names
    assert len(set(styles.values())) == len(names)


def test_a_chart_without_a_point_says_so() -> None:
    study = made()
    study.points = []
    assert "no run has an error to be shown" in chart(study)
    study.title = "a < b & c"
    assert "a &lt; b &amp; c" in chart(study)


def test_labels_cover_neither_points_nor_each_other() -> None:
    root = xml.fromstring(chart(made(0.1), 0.1))
    boxes = []
    for one in root.iter(f"{SPACE}text"):
        if one.get("font-size") == "11.5":
            wide = 5.8 * len(one.text or "")
            x, y = float(one.get("x", 0)), float(one.get("y", 0))
            left = x - (wide if one.get("text-anchor") == "end" else 0)
            boxes.append((left, y - 7, left + wide, y + 7))
    assert boxes
    for i, a in enumerate(boxes):
        for b in boxes[:i]:
            assert not (a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3])


def test_scales_are_logarithmic() -> None:
    scale = Scale([0.01, 1.0], 100.0, 500.0)
    assert scale(0.1) == pytest.approx(300)
    assert scale(1.0) - scale(0.1) == pytest.approx(scale(0.1) - scale(0.01))
    labelled = [value for value, has_label in scale.ticks() if has_label]
    assert labelled == pytest.approx([0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1])
    one = Scale([3.0], 0.0, 1.0)
    assert one(3.0) == pytest.approx(0.5)


def test_words_of_the_chart() -> None:
    assert [step(dt) for dt in (1 / 240, 0.5, 1.0, 0.3)] == ["1/240 s", "1/2 s", "1 s", "0.3 s"]
    assert order_words([{"line": "a", "metric": "e", "in": "dt", "order": None}], "a", "e") == ["no order seen in Δt"]
