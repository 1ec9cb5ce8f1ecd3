"""The strands that presets draw, settled as shipped, beside a path tracer: `make check-against-mitsuba`."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("mitsuba", reason="Mitsuba is not installed: make check-against-mitsuba")

from path_traced_presets import measured

MOST = {"hair": 0.5, "portrait": 0.8}
"""RMSE of the pictures as they are; .1 is aimed at. Settled strands lie on each other, and opacity maps average over
neighbours that hide each other."""


@pytest.mark.parametrize("preset", MOST)
def test_strands_of_presets_have_the_same_direct_light(tmp_path: Path, preset: str) -> None:
    plain, *_, fine = measured(preset, tmp_path)["pictures"].values()
    assert plain["rmse"] < MOST[preset]
    assert abs(plain["brightness"] - 1) < 0.06
    assert fine["rmse"] < plain["rmse"]
