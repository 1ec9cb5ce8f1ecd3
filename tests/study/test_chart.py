"""What is drawn and written of a study: charts in both forms, CSV and the table."""

from __future__ import annotations

import csv
import io
import xml.etree.ElementTree as xml

import numpy as np
import pytest

from strandcli.study.chart import Scale, chart, styles_of
from strandcli.study.drawing import Drawing, Patch, Stroke, Text, dashes, marker, spelled
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


def test_the_chart_shows_every_point_front_and_wish() -> None:
    study = made(0.1)
    drawing = chart(study, 0.1)
    root = xml.fromstring(drawing.svg())
    space = "{http://www.w3.org/2000/svg}"
    texts = [element.text for element in root.iter(f"{space}text")]
    assert {"a made-up solver", "run time", "asked for: 10 %", "one", "two", "thesis: not represented"} <= set(texts)
    rings = [circle for circle in root.iter(f"{space}circle") if circle.get("r") == "9"]
    assert len(rings) == sum(point.pareto for point in study.points)
    pixels = drawing.picture(1.0)
    assert pixels.shape == (drawing.height, drawing.width, 3)
    assert (pixels.reshape(-1, 3).min(1) < 250).mean() > 0.01


def test_no_two_lines_of_a_chart_look_the_same() -> None:
    names = ["thesis", "rod", *"abcdefghijkl"]
    styles = styles_of([Point({}, 1.0, {}, name) for name in names])
    assert list(styles) == names
    assert len(set(styles.values())) == len(names)


def test_a_chart_without_a_point_says_so() -> None:
    study = made()
    study.points = []
    texts = [item.text for item in chart(study).items if isinstance(item, Text)]
    assert "no run has an error to be shown" in texts


def test_labels_cover_neither_points_nor_each_other() -> None:
    drawing = chart(made(0.1), 0.1)
    labels = [item for item in drawing.items if isinstance(item, Text) and item.size == 11.5]
    assert labels
    boxes = []
    for one in labels:
        wide = 5.8 * len(one.text)
        left = one.at[0] - (wide if one.anchor == "end" else 0)
        boxes.append((left, one.at[1] - 7, left + wide, one.at[1] + 7))
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


def test_drawings_are_the_same_in_both_forms() -> None:
    square = Patch([(10, 10), (30, 10), (30, 30), (10, 30)], "#ff0000")
    drawing = Drawing(60, 40, items=[square, Patch([(45, 20)], "#00ff00", radius=8)])
    pixels = drawing.picture(1.0)
    assert tuple(pixels[20, 20]) == (255, 0, 0)
    assert tuple(pixels[20, 45]) == (0, 255, 0)
    assert tuple(pixels[2, 2]) == (255, 255, 255)
    assert 'points="10.0,10.0 30.0,10.0' in drawing.svg()
    text = Text((30, 20), "a < b & c", "#0000ff", upright=True)
    drawing.items = [Stroke([(0, 20), (60, 20)], "#000000", 4, 10.0), text]
    pixels = drawing.picture(1.0)
    assert pixels[20, 5].max() < 20  # scaling down leaves a little of the neighbours
    assert pixels[20, 14].min() > 235
    assert "a &lt; b &amp; c" in drawing.svg()


def test_dashes_go_round_corners() -> None:
    pieces = dashes([(0, 0), (15, 0), (15, 15)], 10)
    lengths = [np.hypot(b[0] - a[0], b[1] - a[1]) for a, b in pieces]
    assert sum(lengths) == pytest.approx(20, abs=1e-6)
    np.testing.assert_allclose(pieces[0], [(0, 0), (10, 0)], atol=1e-6)


def test_words_of_the_chart() -> None:
    assert [step(dt) for dt in (1 / 240, 0.5, 1.0, 0.3)] == ["1/240 s", "1/2 s", "1 s", "0.3 s"]
    assert spelled("Δt² of Γ") == "dt^2 of Gamma"
    assert spelled("plain") == "plain"
    assert order_words([{"line": "a", "metric": "e", "in": "dt", "order": None}], "a", "e") == ["no order seen in Δt"]
    assert marker("star", (0, 0), 1, "#fff").radius == 0
