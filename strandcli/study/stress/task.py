"""What the stability matrix is made of."""

from __future__ import annotations

from typing import NamedTuple

from ...scene.model import Scene
from .axes import Case


class Task(NamedTuple):
    """A piece of work: a batch of cases, one named check or input, a preset's scene with its labels, or one case with
    labels of what strands do together."""

    solver: str
    cases: tuple[Case, ...] = ()
    named: str = ""
    scene: Scene | None = None
    labels: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """What its results are called."""
        return (f"{self.solver}/{self.named}",) if self.named else tuple(case.name for case in self.cases)
