"""The state of a simulation at frame 1, kept beside compiled kernels from one run to the next.

What a preset lets pass before its first frame takes longer than to draw that frame, and is the same in every run that
changes the picture alone: `hair` falls into place for twelve seconds. A later run begins where the first one had come
to, with the very same bits; a state is of one key (see `checkpoints.key_of`), and nothing else is believed of it.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

from ..jit import kept

if TYPE_CHECKING:
    from .checkpoints import Checkpoints
    from .stages import Notify

KIND = "first-frame"
LEAST = 0.2
"""Seconds that it takes to come to frame 1, below which its state is not kept."""


class FirstFrame:
    """Stands for `Checkpoints`, and hands on to those of the run where there are any."""

    def __init__(self, checkpoints: Checkpoints | None, notify: Notify | None) -> None:
        """``notify`` hears where the state comes from."""
        self._checkpoints = checkpoints
        self._notify = notify
        self._began: float | None = None
        """When the simulation of frame 1 began, where its state is not known."""
        self.of_all_strands = checkpoints is not None and checkpoints.of_all_strands

    def of_panel(self, number: int) -> FirstFrame:
        """Return that of a panel of the scene, counted from 1."""
        return FirstFrame(self._checkpoints.of_panel(number) if self._checkpoints else None, self._notify)

    def go_on(self, solver: Any, after: int, last: int) -> int:
        """Bring a solver to the latest known state of the frames ``after`` + 1 to ``last``; return its frame, or
        ``after`` where there is none."""
        found = self._checkpoints.go_on(solver, after, last) if self._checkpoints is not None else after
        if found > 0 or last < 1 or solver.scene.time.preroll <= 0:
            return found
        arrays = solver.state_arrays()
        state = kept.find(KIND, _key(solver), arrays) if arrays else None
        try:
            if state is not None:
                solver.check(state, 1)
                solver.restore(state)
        except ValueError:  # it is made again
            state = None
        if state is None:
            self._began = time.perf_counter()
            return found
        if self._notify is not None:
            self._notify("frame 1 as an earlier run left it")
        return 1

    def keep(self, solver: Any, frame: int) -> None:
        """Keep the state of frame 1, if it took long to come to."""
        if self._checkpoints is not None:
            self._checkpoints.keep(solver, frame)
        if frame == 1 and self._began is not None and time.perf_counter() - self._began >= LEAST:
            kept.keep(KIND, _key(solver), solver.state_arrays())
        self._began = None


def _key(solver: Any) -> str:
    from .checkpoints import key_of

    return kept.key_of(KIND, (__name__,), (key_of(solver.scene), solver.groom.strands))
