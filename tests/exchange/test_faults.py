"""Strands at fault, against a twin in Python."""

from __future__ import annotations

import numpy as np
import pytest

import exchange_kit as kit
from strandcli.exchange import faults


@pytest.mark.parametrize("chunk", [7, 64, 1 << 20])
def test_strands_that_repeat_another_are_found(chunk: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Among strands of few points and few values, of which some differ in a last point at the origin alone."""
    generator = np.random.default_rng(0)
    strands = [
        generator.integers(0, 2, (generator.integers(2, 5), 3)).astype(np.float32) * generator.choice([1, -1])
        for _ in range(1500)
    ]
    seen: set[bytes] = set()
    expected = []
    for one in strands:
        expected.append(one.tobytes() in seen)
        seen.add(one.tobytes())
    assert 100 < sum(expected) < 1400
    monkeypatch.setattr(faults, "CHUNK", chunk)
    assert faults.repeated(kit.of(strands)).tolist() == expected


def test_strands_that_are_not_finite_or_have_no_length_are_found() -> None:
    good = np.arange(9, dtype=np.float32).reshape(3, 3)
    bad = good.copy()
    bad[2, 1] = np.inf
    strands = kit.of([good, bad, good[:1].repeat(4, axis=0), bad, good])
    assert faults.not_finite(strands).tolist() == [False, True, False, True, False]
    assert faults.without_length(kit.of([good, good[:1].repeat(4, axis=0)])).tolist() == [False, True]
