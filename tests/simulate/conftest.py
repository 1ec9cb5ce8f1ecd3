"""What tests of simulation share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from strandcli.simulate.contact.between_strands import StrandContact


@pytest.fixture
def steps(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Any, Any]]:
    """Where particles were at begin and end of all parts of steps."""
    found: list[tuple[Any, Any]] = []
    make = StrandContact.step

    def step(self: StrandContact, run: Callable[[], None], dt: float, solver: Any) -> bool:
        before = self._particles(solver.state)
        done = make(self, run, dt, solver)
        if done:
            found.append((before, self._particles(solver.state)))
        return done

    monkeypatch.setattr(StrandContact, "step", step)
    return found
