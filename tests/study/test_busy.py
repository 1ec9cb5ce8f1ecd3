"""Whether figures of speed say that the machine was busy."""

from __future__ import annotations

import os
from typing import Any

import pytest

from strandcli.study import bench
from strandcli.study.bench import Load, busy_words

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
