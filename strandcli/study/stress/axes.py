"""The axes of the stability matrix and what a case is: one value of each, and a name to call it by.

A name is the solver and every axis that departs from its default: ``rod/dt=0.5/start=folded``. Quantities are free of
dimensions: lengths in strand lengths L, the bending rigidity B in ρ A L⁴ / s², gravity as Γ = ρ A g L³ / B.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...errors import UsageError
from ...scene.faults import hint, shown

SOLVERS = ("rod", "thesis")

AXES: dict[str, dict[str, Any]] = {
    # the step in seconds, before it is divided by the substeps; noisy: 1/60 s and up to 50 % more or less each time
    "dt": {
        "1e-4": 1e-4,
        "240Hz": 1 / 240,
        "60Hz": 1 / 60,
        "24Hz": 1 / 24,
        "0.5": 0.5,
        "10": 10.0,
        "noisy": 1 / 60,
    },
    "substeps": {"1": 1, "2": 2, "8": 8},
    "B": {"0": 0.0, "1e-6": 1e-6, "1e-2": 1e-2, "1": 1.0, "1e2": 1e2, "1e6": 1e6},
    "gamma": {"0": 0.0, "0.1": 0.1, "7.7": 7.7, "7.9": 7.9, "10": 10.0, "100": 100.0, "1e4": 1e4},
    "wind": {"calm": 0.0, "gale": 1e3},
    "emitter": {"still": None, "teleport": None, "flip": None, "shake": None},
    "contact": {"none": None, "inside": None, "through": None, "overlap": None, "small": None, "moving": None},
    "n": {"1": 1, "2": 2, "3": 3, "10": 10, "32": 32, "100": 100, "1000": 1000},
    "L": {"1e-6": 1e-6, "1": 1.0, "1e6": 1e6},
    "offset": {"0": 0.0, "1e6": 1e6},
    # mass a length at the tip over that at the root
    "tip": {"1e-6": 1e-6, "1e-3": 1e-3, "1": 1.0, "1e3": 1e3, "1e6": 1e6},
    "strands": {"1": 1, "2": 2, "4": 4, "129": 129, "700": 700},
    "lengths": {"equal": 0.0, "unequal": 0.9},
    "start": {"straight": None, "zero": None, "coincident": None, "folded": None, "random": None},
}
"""Values by label. ``n`` counts segments; ``start=zero`` has one segment without length, ``coincident`` has all."""

DEFAULTS = {
    "dt": "60Hz", "substeps": "1", "B": "1", "gamma": "10", "wind": "calm", "emitter": "still", "contact": "none",
    "n": "10", "L": "1", "offset": "0", "tip": "1", "strands": "1", "lengths": "equal", "start": "straight",
}  # fmt: skip


@dataclass(frozen=True)
class Case:
    """One scene of the matrix: a solver and a label for each axis, in the order of `AXES`."""

    solver: str
    labels: tuple[str, ...]

    @staticmethod
    def of(solver: str, labels: Mapping[str, str] | None = None) -> Case:
        """The case with these labels and defaults for the rest."""
        return Case(solver, tuple({**DEFAULTS, **(labels or {})}[axis] for axis in AXES))

    def label(self, axis: str) -> str:
        """The label on one axis."""
        return self.labels[_PLACE[axis]]

    def value(self, axis: str) -> Any:
        """The number behind the label on one axis."""
        return AXES[axis][self.label(axis)]

    @property
    def name(self) -> str:
        """What it is called: the solver and all that departs from the defaults."""
        given = zip(AXES, self.labels, strict=True)
        return "/".join([self.solver, *(f"{axis}={label}" for axis, label in given if label != DEFAULTS[axis])])

    @property
    def parameters(self) -> dict[str, str]:
        """Every axis with its label."""
        return dict(zip(AXES, self.labels, strict=True))


_PLACE = {axis: place for place, axis in enumerate(AXES)}


def case_named(name: str) -> Case:
    """The case of a name. Raises `UsageError` that says which part is not known."""
    solver, *parts = name.split("/")
    if solver not in SOLVERS:
        raise UsageError(f"--case {name}: begins with the solver; {hint(solver, SOLVERS, 'the solvers are')}")
    labels: dict[str, str] = {}
    for part in parts:
        axis, _, label = part.partition("=")
        if axis not in AXES:
            raise UsageError(f"--case {name}: unknown axis {shown(axis)}; {hint(axis, AXES, 'the axes are')}")
        if label not in AXES[axis]:
            raise UsageError(f"--case {name}: {axis} has no value {shown(label)}; it has {', '.join(AXES[axis])}")
        if axis in labels:
            raise UsageError(f"--case {name}: gives {axis} twice")
        labels[axis] = label
    return Case.of(solver, labels)
