"""The table over several studies: a row for each subject and solver, those that cannot be measured included."""

from __future__ import annotations

import pytest

from strandcli.study import report
from study_kit import made


def test_a_row_for_each_subject_and_solver() -> None:
    rows = report.summary([made(), made()], 0.05)
    assert [row["solver"] for row in rows] == ["one", "two", "thesis"] * 2
    one, two, absent = rows[:3]
    # the finest of 33 particles and 0.005 s is the best of both
    assert one["error"] == pytest.approx(0.3 * 0.05 + 0.3 / 32**2)
    assert one["knobs"] == {"solver": "one", "emitter.particles": 33, "dt": 0.005}
    assert two["error"] == pytest.approx(0.3 * 0.05**2 + 0.3 / 32**2)
    assert two["seconds"] == pytest.approx(33 / 0.005 * 4e-4)
    assert (one["order_dt"], two["order_dt"]) == (pytest.approx(1, abs=0.02), pytest.approx(2, abs=0.02))
    # under 5 % five particles will do, which leave 1.9 %, with steps of 0.01 s (3 %), or 0.02 s (1.2 %) at second order
    assert one["seconds_under"] == pytest.approx(5 / 0.01 * 1e-4)
    assert two["seconds_under"] == pytest.approx(5 / 0.02 * 4e-4)
    assert absent == {"subject": "synthetic", "solver": "thesis", "not_represented": "not represented: inertia"}


def test_the_table_says_what_cannot_be_measured_and_what_is_not_reached() -> None:
    lines = report.summary_text([made(margin=0.2)], 0.001).splitlines()
    assert len(lines) == 4
    assert "under 0.1 % in" in lines[0]
    assert lines[1].split()[:4] == ["synthetic", "one", "1.53", "%"]
    assert "33 particles, step 1/200 s" in lines[1]
    assert lines[1].endswith(" -")
    assert lines[3].split()[:2] == ["synthetic", "thesis"]
    assert lines[3].endswith("not represented: inertia")
    assert max(map(len, lines)) <= 120
