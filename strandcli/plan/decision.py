"""What a driver says of itself before a run: whether a stage runs, and why. Imports nothing."""

from __future__ import annotations

from typing import NamedTuple


class Decision(NamedTuple):
    """A stage of a run, the reason why it is run or left out, and which of the two."""

    stage: str
    why: str
    runs: bool = True


def left_out(stage: str, why: str) -> Decision:
    """A stage that is not run."""
    return Decision(stage, why, runs=False)
