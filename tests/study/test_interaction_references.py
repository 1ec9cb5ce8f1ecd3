"""References of strands that touch: friction at a slope, layers that are pressed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from strandcli.study.references import Track, incline, layer
from strandcli.study.references.experiment import track_of


def test_the_angle_of_friction_is_where_ways_of_sliding_strands_vanish() -> None:
    made = incline.strands()
    start = np.zeros((2, made.strands, 3, 3))
    rows = np.arange(0, made.strands, 1 + len(incline.RAILS))

    def angle(begin: float, stuck: float = 0.004) -> float | None:
        positions = start.copy()
        off = np.array(incline.OFF)
        positions[1, rows, -1, 2] = np.where(off > begin, 0.013 * (off - begin), stuck)
        return incline.measure(Track(np.array([0.0, 1.0]), positions))["angle"]

    assert angle(0) == pytest.approx(0, abs=1e-9)
    assert angle(-2) == pytest.approx(2 / incline.exact()["angle"], rel=1e-6)
    assert angle(4) is None  # none slides
    assert angle(0, 0.02) is None  # those that should stick move as far as those that slide


def test_a_strand_across_others_begins_to_slide_at_the_angle_of_friction() -> None:
    found = incline.measure(track_of(incline.case(11), 1 / 60, incline.INCLINE.span))["angle"]
    assert found is not None
    assert found * incline.exact()["angle"] < 0.6


def test_an_even_layer_has_its_density_and_a_pile_before_the_plate_its_own() -> None:
    made = layer.strands()
    half = made.strands // 2
    share = np.linspace(0, 1, 11)[:, None] * [0.0, -layer.LENGTH, 0.0]
    x = made.roots[:, None].astype(float) + share
    x[..., 0] -= layer.MEASURED  # as they stand, beside the plate
    found = layer.measure(Track(np.zeros(1), x[None]))
    assert found["pressed"] == pytest.approx(1 - layer.SPARSE / layer.DENSE, abs=0.01)
    assert found["sprung back"] == found["pressed"]
    face = layer.DEPTH / 2 - layer.MEASURED
    x[half:, :, 0] = face + (x[half:, :, 0] - face) * layer.SPARSE / layer.DENSE
    found = layer.measure(Track(np.zeros(1), x[None]))
    assert found["sprung back"] == pytest.approx(0, abs=0.01)
    assert found["density"] == found["pressed"]


@pytest.mark.long
def test_a_pressed_layer_keeps_its_density_both_ways() -> None:
    """Within 1 %; without the rule all that the plate sweeps together is at its face."""
    case = layer.case(11)
    errors = {}
    for rule in ("interaction", None):
        rules = case.settings["rules"] if rule else ["gravity", "collision"]
        one = replace(case, settings={**case.settings, "rules": rules})
        errors[rule] = layer.measure(track_of(one, 1 / 60, layer.LAYER.span))["density"]
    assert errors["interaction"] < 0.01  # type: ignore[operator]
    assert errors[None] > 0.15  # type: ignore[operator]
