"""How much of the processor other programs took while something was timed."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping

OTHERS, STOLEN = 0.1, 0.02
"""Shares from which on times are not those of an idle machine."""
USER, NICE, SYSTEM, IDLE, WAIT, IRQ, SOFT_IRQ, STEAL = range(8)
"""Columns of a processor in /proc/stat."""


def busy_words(busy: Mapping[str, float] | None) -> str:
    """A warning of what `Load.since` tells; "" for an idle machine."""
    if busy is None:
        return ""
    found = [f"other programs took {100 * busy['others']:.0f} %"] if busy["others"] > OTHERS else []
    found += [f"the host took {100 * busy['stolen']:.0f} %"] if busy["stolen"] > STOLEN else []
    return f"the machine was busy: {' and '.join(found)} of its processors' time" if found else ""


class Load:
    """Watches the processors from when it is made."""

    def __init__(self) -> None:
        self._began = _columns(), time.process_time()

    def since(self) -> dict[str, float] | None:
        """Shares of their time since then: that ``others`` took, and that a virtual machine's host had ``stolen``; None
        where the system does not tell."""
        (before, own_before), (now, own) = self._began, (_columns(), time.process_time())
        if before is None or now is None:
            return None
        spent = [b - a for a, b in zip(before, now, strict=True)]
        whole = max(1, sum(spent))
        working = whole - spent[IDLE] - spent[WAIT] - spent[STEAL]
        mine = (own - own_before) * os.sysconf("SC_CLK_TCK")
        return {"others": max(0.0, working - mine) / whole, "stolen": spent[STEAL] / whole}


def _columns() -> list[int] | None:
    """Ticks of what the processors that this process may use have done, by column; None where Linux is not there."""
    try:
        with open("/proc/stat", encoding="ascii") as file:
            lines = [line.split() for line in file if line.startswith("cpu") and line[3].isdigit()]
        mine = {f"cpu{number}" for number in os.sched_getaffinity(0)}
        rows = [[int(one) for one in words[1 : STEAL + 2]] for words in lines if words[0] in mine]
    except (OSError, ValueError, AttributeError):
        return None
    return [sum(column) for column in zip(*rows, strict=True)] or None
