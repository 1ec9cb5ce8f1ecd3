"""Claims: repeats with their spread, as a table, CSV and chart; and whether figures say that the machine was busy."""

from __future__ import annotations

import csv
import json
import os
import sys
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import pytest

from cli_runs import Runner
from strandcli.study import bench, claims
from strandcli.study.bench import Load, busy_words

ROWS = [
    claims.row("frames a second", "25-30", "ours", "frames a second", [27.0, 40.0, 20.0], (25, 30)),
    claims.row("cut < strands", "none", "ours", "%", [45.0]),
]


def test_repeats_are_told_by_median_and_spread(monkeypatch: pytest.MonkeyPatch) -> None:
    frames = iter([40.0, 30.0, 400.0, 20.0, 18.0, 500.0, 50.0, 20.0, 100.0])  # of three repeats: all, straight, many
    work = {"curves": [0.001], "shadow": [0.002], "shade": [0.017], "write": [9.0]}

    def timed(*given: Any) -> dict[str, Any]:
        return {"frame_ms": next(frames), "seconds": work, "busy": {"others": 0.0, "stolen": 0.0}}

    monkeypatch.setattr(claims, "time_frames", timed)
    fps, many, smoothing, shadow = claims._speed([claims._timed(1) for _ in range(3)])
    assert fps["values"] == [25.0, 50.0, 20.0]
    assert fps["ours"].startswith("25 (20 to 50) ")
    assert (fps["range"], many["values"]) == ([25, 30], [2.5, 2.0, 10.0])
    assert smoothing["values"] == pytest.approx([5.0] * 3)
    assert " 25 (10 to 60) % less" in smoothing["ours"]
    assert shadow["values"] == pytest.approx([10.0] * 3)
    assert claims.spread_words([45.0]) == "45"


def test_csv_and_chart_are_written_where_they_are_asked_for(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: dict[str, Any] = {}

    def fake(**options: Any) -> dict[str, Any]:
        asked.update(options)
        return {"claims": ROWS, "busy": {"others": 0.5, "stolen": 0.0}}

    module = SimpleNamespace(run=fake, chart=claims.chart)
    monkeypatch.setitem(sys.modules, "strandcli.study.claims", module)
    monkeypatch.setattr("strandcli.study.claims", module)
    done = run("claims", "-o", "c", "--json")
    assert json.loads(done.out)["claims"] == ROWS
    assert asked["repeats"] == 5
    assert "other programs took 50 %" in done.error()
    with open("c/claims.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(rows[0][name]) for name in ("median", "least", "greatest", "repeats")] == [27, 20, 40, 3]
    assert (rows[1]["claim"], rows[1]["quantity"], rows[1]["repeats"]) == ("cut < strands", "%", "1")
    ElementTree.parse("c/claims.svg")
    assert "add --overwrite" in run("claims", "-o", "c").error()
    assert run("claims", "-o", "c", "--overwrite", "--repeats", "2", "-q").err == ""
    assert asked["repeats"] == 2


def test_the_chart_places_ours_beside_the_sources_range() -> None:
    name = "{http://www.w3.org/2000/svg}"
    root = ElementTree.fromstring(claims.chart(ROWS))
    lines = [line for line in root.iter(f"{name}polyline") if line.get("stroke") != claims.GRID]
    (band, spread, single), (dot, _) = lines, root.iter(f"{name}circle")

    def places(line: ElementTree.Element) -> list[float]:
        return [float(at.split(",")[0]) - claims.LEFT for at in str(line.get("points")).split()]

    (low, high), (least, greatest) = places(band), places(spread)
    assert (low + 1) / (high - 1) == pytest.approx(25 / 30, abs=0.002)
    assert least / greatest == pytest.approx(20 / 40, abs=0.002)
    assert (float(str(dot.get("cx"))) - claims.LEFT) / greatest == pytest.approx(27 / 40, abs=0.002)
    assert places(single)[0] == places(single)[1]
    assert greatest < claims.WIDTH - claims.RIGHT - claims.LEFT


TICKS = os.sysconf("SC_CLK_TCK")


def watched(monkeypatch: pytest.MonkeyPatch, own: float, spent: list[int]) -> dict[str, float] | None:
    """What `Load` tells where this process took ``own`` seconds, and processors ``spent`` ticks by column."""
    moments = iter([([100] * 8, 5.0), ([100 + one for one in spent], 5.0 + own)])
    now: list[Any] = []

    def columns() -> list[int]:
        now[:] = next(moments)
        return list(now[0])

    monkeypatch.setattr(bench, "_columns", columns)
    monkeypatch.setattr(bench.time, "process_time", lambda: now[1])
    return Load().since()


def test_what_others_and_the_host_take_is_told_apart_from_our_own(monkeypatch: pytest.MonkeyPatch) -> None:
    second = TICKS
    found = watched(monkeypatch, 1.0, [second, 0, second, 7 * second, 0, 0, 0, second])
    assert found == pytest.approx({"others": 0.1, "stolen": 0.1})
    assert busy_words(found) == "the machine was busy: the host took 10 % of its processors' time"
    found = watched(monkeypatch, 1.0, [3 * second, second, 0, 6 * second, 0, 0, 0, 0])
    assert busy_words(found) == "the machine was busy: other programs took 30 % of its processors' time"
    alone = watched(monkeypatch, 4.0, [4 * second, 0, 0, 5 * second, second, 0, 0, 0])
    assert alone == {"others": 0.0, "stolen": 0.0}
    assert busy_words(alone) == ""


def test_a_system_that_does_not_tell_is_not_called_busy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench, "_columns", lambda: None)
    assert Load().since() is None
    assert busy_words(None) == ""


@pytest.mark.skipif(not os.path.exists("/proc/stat"), reason="Linux tells")
def test_this_machine_tells_shares() -> None:
    load = Load()
    sum(range(1_000_000))
    found = load.since()
    assert all(0 <= share <= 1 for share in found.values())
