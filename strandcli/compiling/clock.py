"""The seconds that a process has waited for kernels to be compiled, and how many it waits for.

Counted by strandcli's own dispatchers: Numba's events would tell of every function of the process. `COSTS` lists which
kernels the shipped presets need, and the seconds that compiling each took where `make kernel-costs` ran, on one core;
where there are more, a run waits for about half.
"""

from __future__ import annotations

import json
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..common import limits

Notify = Callable[[str], None]
COSTS = Path(__file__).with_name("costs.json")
USUAL = 1.0
"""Seconds of a kernel that was not measured."""
PRIOR = 5.0
"""Seconds of compiling that the measured costs are believed for, before this machine's own tell more."""


class Clock:
    """Adds up compile time; a kernel compiled while another is compiled counts once, each thread for itself."""

    def __init__(self) -> None:
        self.notify: Notify | None = None
        """Is handed a line of text each time that compiling begins."""
        self.waited: Counter[str] = Counter()
        """Seconds for each kernel that was compiled, by its name: module and function."""
        self.compiled = 0
        """Signatures that were compiled."""
        self.ready: Counter[str] = Counter()
        """How many signatures of each kernel this process has called, compiled or loaded."""
        self._sources: dict[str, None] = {}
        self._present: tuple[str, float] | None = None
        self._thread = threading.local()

    @property
    def seconds(self) -> float:
        """Of all that was compiled."""
        return sum(self.waited.values())

    def expect(self, source: str) -> None:
        """A scene of this file is drawn now."""
        self._sources[source] = None

    @contextmanager
    def call(self, name: str) -> Iterator[None]:
        """A dispatcher looks for a kernel; the time counts from `missed` on, if that is called."""
        mine = self._thread
        mine.depth = getattr(mine, "depth", 0) + 1
        if mine.depth == 1:
            mine.name = name
        try:
            yield
        finally:
            mine.depth -= 1
            if mine.depth == 0:
                self._stop()

    def missed(self, name: str) -> None:
        """The kernel is not in the cache: compiling begins."""
        mine = self._thread
        if getattr(mine, "depth", 0) > 0 and getattr(mine, "began", None) is None:
            mine.began = time.perf_counter()
            self._present = mine.name, mine.began
            self.tell(f"compiling {name}")

    def progress(self) -> tuple[int, int, float]:
        """How many kernels are ready or nearly so, the one among them that is compiled now; how many all scenes of this
        process need, 0 where that is not known, and the seconds left."""
        expected: Counter[str] = Counter()
        for source in list(self._sources):
            expected |= kernels_of(source)
        present = self._present
        if not expected or present is None:
            return self.ready.total() + 1, 0, 0.0
        ready = self.ready.copy()
        reached = ready + Counter([present[0]])
        pace = (self.seconds + PRIOR / min(max(limits.compilers(), 1), 2)) / (seconds_of(ready) + PRIOR)
        now, later = seconds_of(expected - ready), seconds_of(expected - reached)
        left = max(pace * now - (time.perf_counter() - present[1]), pace * later)
        return reached.total(), (expected | reached).total(), left

    def tell(self, words: str) -> None:
        """Hand ``words`` to `notify`."""
        if self.notify is not None:
            self.notify(words)

    def _stop(self) -> None:
        mine = self._thread
        began = getattr(mine, "began", None)
        if began is not None:
            self.waited[mine.name] += time.perf_counter() - began
            mine.began = None
            self.compiled += 1
        self.ready[mine.name] += 1


def kernels_of(source: str) -> Counter[str]:
    """The kernels of the shipped preset in a file, by how many signatures of each it needs; none of other files, nor of
    a scene that is of no file, whose source is ""."""
    presets = _table()["presets"]
    path = Path(source).as_posix()
    return next((Counter(found) for name, found in presets.items() if path.endswith(f"presets/{name}.yaml")), Counter())


def seconds_of(kernels: Counter[str]) -> float:
    """What compiling them took."""
    known = _table()["seconds"]
    return sum(known.get(name, USUAL) * count for name, count in kernels.items())


def _table() -> dict[str, Any]:
    try:
        return dict(json.loads(COSTS.read_text(encoding="utf-8")))
    except (OSError, ValueError):
        return {"seconds": {}, "presets": {}}


clock = Clock()
