"""The example that sets rods beside PyElastica: our side of it, and what is said where PyElastica is missing."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import Any

import pytest

SCRIPT = Path(__file__).resolve().parents[2] / "examples" / "against_pyelastica.py"


@pytest.fixture(scope="module")
def example() -> Any:
    spec = importlib.util.spec_from_file_location("against_pyelastica", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["against_pyelastica"] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


def test_without_pyelastica_one_line_says_what_to_install(
    example: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "elastica", None)
    assert example.main([]) == 1
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err == "PyElastica is not installed here: pip install pyelastica\n"


def test_a_strand_comes_to_rest_near_the_elastica_and_nearer_with_more_segments(example: Any) -> None:
    few, more = (example.of_strandcli(10.0, segments, 3) for segments in (9, 18))
    assert few.error == pytest.approx(0.0102, rel=0.05)
    assert 3.5 < few.error / more.error < 4.5
    assert few.seconds > 0
    assert example.off((0.0, 0.0, 0.0), 10.0) == pytest.approx(0.958, abs=0.002)


def test_a_step_is_stable_where_the_next_smaller_one_agrees(example: Any) -> None:
    def run(step: float, error: float) -> Any:
        return example.Run("PyElastica", 10, step, 1, error, 1.0)

    wild, coarse, fine = run(0.4, float("nan")), run(0.3, 0.004), run(0.2, 0.00401)
    assert example.settled([wild, coarse, fine]) is coarse
    assert example.settled([wild, coarse]) is None
