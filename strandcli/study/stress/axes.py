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

GRID = {
    "grid": {"density": 10.0, "cell": 0.2}, "grid-fine": {"density": 1e3, "cell": 0.05, "friction": 1.0},
    "grid-coarse": {"density": 1.0, "cell": 0.9, "friction": 0.0},
}  # fmt: skip
"""Settings of the rule interaction, for an L of 1."""
CONTACT = {
    "thin": {"thickness": 0.005, "iterations": 3},
    "thick": {"thickness": 0.02, "friction": 1.0, "iterations": 3},
}
"""Settings of the rule contact, for an L of 1."""

AXES: dict[str, dict[str, Any]] = {
    # the step in seconds, before it is divided by the substeps; noisy: 1/60 s and up to 50 % more or less each time
    "dt": {
        "1e-4": 1e-4, "240Hz": 1 / 240, "60Hz": 1 / 60, "24Hz": 1 / 24, "0.5": 0.5, "10": 10.0, "noisy": 1 / 60,
    },
    "substeps": {"1": 1, "2": 2, "8": 8},
    "B": {"0": 0.0, "1e-6": 1e-6, "1e-2": 1e-2, "1": 1.0, "1e2": 1e2, "1e6": 1e6},
    "gamma": {"0": 0.0, "0.1": 0.1, "7.7": 7.7, "7.9": 7.9, "10": 10.0, "100": 100.0, "1e4": 1e4},
    "wind": {"calm": 0.0, "gale": 1e3},
    "emitter": dict.fromkeys(("still", "teleport", "flip", "shake")),
    "contact": dict.fromkeys(("none", "inside", "through", "overlap", "small", "moving")),
    "n": {"1": 1, "2": 2, "3": 3, "10": 10, "32": 32, "100": 100, "1000": 1000},
    "L": {"1e-6": 1e-6, "1": 1.0, "1e6": 1e6},
    "offset": {"0": 0.0, "1e6": 1e6},
    # mass a length at the tip over that at the root
    "tip": {"1e-6": 1e-6, "1e-3": 1e-3, "1": 1.0, "1e3": 1e3, "1e6": 1e6},
    "strands": {"1": 1, "2": 2, "4": 4, "129": 129, "700": 700},
    "lengths": {"equal": 0.0, "unequal": 0.9},
    "start": dict.fromkeys(("straight", "zero", "coincident", "folded", "random")),
    "between": {
        "none": {},
        **{label: {"interaction": given} for label, given in GRID.items()},
        **{label: {"contact": given} for label, given in CONTACT.items()},
        "grid-thin": {"interaction": GRID["grid"], "contact": CONTACT["thin"]},
    },
    "twist": {"none": {}, "coil": {"rest": "shape"}, "sag-free": {"rest": "sag_free"}},
    "end": {"free": "free", "pinned": "pinned"},
    "root": {"clamped": "clamped", "hinged": "hinged"},
    "torsion": {"none": None, "0.7": 0.7},
    "collide": {"particles": False, "segments": True},
}  # fmt: skip
"""Values by label. ``n`` counts segments; ``start=zero`` has one segment without length, ``coincident`` has all;
``between`` has rules with their settings, and ``twist`` settings of rod: strands of coils begin as such."""
GROUPED = ("between", "twist", "end", "root", "torsion")
"""Axes of rods alone, in grooms of a few strands each."""

DEFAULTS = {
    "dt": "60Hz", "substeps": "1", "B": "1", "gamma": "10", "wind": "calm", "emitter": "still", "contact": "none",
    "n": "10", "L": "1", "offset": "0", "tip": "1", "strands": "1", "lengths": "equal", "start": "straight",
    "between": "none", "twist": "none", "end": "free", "root": "clamped", "torsion": "none", "collide": "particles",
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

    def with_labels(self, **labels: str) -> Case:
        """The same case with other labels on some axes."""
        return Case.of(self.solver, self.parameters | labels)

    def label(self, axis: str) -> str:
        """The label on one axis."""
        return self.labels[_PLACE[axis]]

    def value(self, axis: str) -> Any:
        """The value behind the label on one axis."""
        return AXES[axis][self.label(axis)]

    @property
    def grouped(self) -> bool:
        """Whether it departs from the defaults on one of the axes of `GROUPED`."""
        return any(self.label(axis) != DEFAULTS[axis] for axis in GROUPED)

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


def refusal(case: Case) -> str:
    """Why no preset can ask for such a case; "" where one can."""
    if case.grouped and case.solver != "rod":
        return f"{', '.join(GROUPED)} are axes of the solver rod"
    if case.label("twist") == "sag-free" and case.label("root") == "hinged":
        return "hinged roots hold no strand up, and sag-free ones hang still"
    return ""


def case_named(name: str) -> Case:
    """The case of a name. Raises `UsageError` that says which part is not known, or why no preset can ask for it."""
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
    case = Case.of(solver, labels)
    if why := refusal(case):
        raise UsageError(f"--case {name}: {why}")
    return case
