"""The axes of the stability matrix, its cases (one value of each axis), and which of these are run.

A case's name is the solver and every axis that departs from its default: ``rod/dt=0.5/start=folded``. Quantities are
free of dimensions: lengths in strand lengths L, the bending rigidity B in ρ A L⁴ / s², gravity as Γ = ρ A g L³ / B.

The product of all axes has tens of millions of cases. In full, for one strand, with every step length and every start:
what moves it (rigidity, weight, wind, emitter); what it touches (contact, rigidity, wind, emitter); what measures it
(segments, length, place, tapering); substeps with rigidity and weight. Beyond these, pairs of every axis with every
other, long strands included, for one strand and for grooms; of rods every combination of what strands do to each other,
twist by and are pinned by meets pairs of the other axes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import chain, combinations, product
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
        return self.labels[list(AXES).index(axis)]

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


SHEETS: dict[str, dict[str, tuple[str, ...]]] = {
    "motion": {"gamma": ("0", "7.9", "10", "1e4"), "dt": (), "B": (), "wind": (), "emitter": (), "start": ()},
    "contact": {"B": ("0", "1e-2", "1", "1e6"), "dt": (), "wind": (), "emitter": (), "contact": (), "start": ()},
    "size": {"n": ("1", "2", "3", "10"), "dt": (), "L": (), "offset": (), "tip": (), "start": ()},
    "substeps": {"gamma": ("0", "7.7", "1e4"), "dt": (), "substeps": (), "B": (), "start": ()},
}
"""Axes of full products, with the labels that are taken; none: all."""
ALONE = tuple(axis for axis in AXES if axis not in ("strands", "lengths", "start", "collide", *GROUPED))
SHORT = ("1", "2", "3", "10")
"""Segments of cheap strands."""
QUICK = {
    "dt": ("60Hz", "10", "noisy"), "B": ("0", "1", "1e6"), "gamma": ("0", "7.9", "1e4"), "wind": ("calm", "gale"),
    "emitter": ("still", "flip"), "contact": ("none", "through"), "start": tuple(AXES["start"]),
}  # fmt: skip
"""The small matrix of a test: short strands alone, so that little is compiled."""
BESIDE: dict[str, tuple[str, ...]] = {
    "dt": (), "substeps": (), "B": ("0", "1e-2", "1", "1e6"), "gamma": ("0", "10", "1e4"), "wind": (), "emitter": (),
    "contact": (), "n": ("1", "2", "10"), "L": (), "tip": ("1e-3", "1", "1e3"), "start": (), "root": (), "torsion": (),
}  # fmt: skip
"""Axes whose pairs every combination of `between`, `twist` and `end` meets."""

Row = dict[str, str]
Pair = tuple[str, str, str, str]


def pairs_of(row: Mapping[str, str]) -> set[Pair]:
    """Every (axis, value, axis, value) of a row, axes in the row's own order."""
    return {(a, row[a], b, row[b]) for a, b in combinations(row, 2)}


def all_pairs(axes: Mapping[str, Sequence[str]]) -> dict[Pair, None]:
    """Every pair that has to be covered, in a fixed order."""
    return {(a, x, b, y): None for a, b in combinations(axes, 2) for x in axes[a] for y in axes[b]}


def covering(axes: Mapping[str, Sequence[str]]) -> list[Row]:
    """Rows in which every two values of any two axes meet, greedily: each row begins with the first pair that is still
    open, and takes, axis by axis, the value that closes most open pairs with what the row holds already; of equal ones
    each in its turn. No randomness. Faults of several axes at once are mostly faults of two (Kuhn, Wallace & Gallo
    2004), and pairs need hundreds of times fewer rows than the full product."""
    open_pairs = all_pairs(axes)
    order = {axis: place for place, axis in enumerate(axes)}
    turn = dict.fromkeys(axes, 0)
    rows: list[Row] = []
    while open_pairs:
        a, x, b, y = next(iter(open_pairs))
        chosen = {a: x, b: y}

        def closes(axis: str, value: str, chosen: Row = chosen) -> int:
            return sum(
                ((axis, value, other, has) if order[axis] < order[other] else (other, has, axis, value)) in open_pairs
                for other, has in chosen.items()
            )

        # axes of many values first: they are the hardest to satisfy
        for axis in sorted(axes, key=lambda name: -len(axes[name])):
            if axis not in chosen:
                gains = [closes(axis, value) for value in axes[axis]]
                best = [value for value, gain in zip(axes[axis], gains, strict=True) if gain == max(gains)]
                turn[axis] += 1
                chosen[axis] = best[turn[axis] % len(best)]
        rows.append({axis: chosen[axis] for axis in axes})
        for pair in pairs_of(rows[-1]):
            open_pairs.pop(pair, None)
    return rows


def pairs(solver: str) -> Iterator[Case]:
    """One strand: pairs of all axes, each row from every start, which costs nothing more."""
    for row in covering({axis: tuple(AXES[axis]) for axis in ALONE}):
        for start in AXES["start"]:
            yield Case.of(solver, {**row, "start": start})


def grooms(solver: str) -> Iterator[Case]:
    """Many strands: pairs of all axes, for short strands and for long ones with few of them."""
    table = {axis: tuple(AXES[axis]) for axis in AXES if axis not in ("collide", *GROUPED)}
    table |= {"strands": ("2", "129", "700"), "n": (*SHORT, "32")}
    for row in covering(table):
        yield Case.of(solver, row)


def segments() -> Iterator[Case]:
    """Rods: random strands whose whole segments stay out of spheres, and not their particles alone."""
    for contact, n in product(("inside", "through", "small", "moving"), ("3", "10")):
        yield Case.of("rod", {"contact": contact, "n": n, "strands": "129", "start": "random", "collide": "segments"})


def groups() -> Iterator[Case]:
    """Rods: pairs of the axes of `BESIDE` for every combination of what strands do to each other, twist by, and are
    pinned by."""
    rows = covering({axis: taken or tuple(AXES[axis]) for axis, taken in BESIDE.items()})
    for between, twist, end in product(AXES["between"], AXES["twist"], AXES["end"]):
        for row in rows:
            case = Case.of("rod", {**row, "between": between, "twist": twist, "end": end})
            if not refusal(case):
                yield case


@cache
def full(solver: str) -> tuple[Case, ...]:
    """The whole matrix of one solver, each case once."""
    products = (
        Case.of(solver, dict(zip(axes, labels, strict=True)))
        for axes in SHEETS.values()
        for labels in product(*(taken or tuple(AXES[axis]) for axis, taken in axes.items()))
    )
    own = chain(segments(), groups()) if solver == "rod" else ()
    return tuple(dict.fromkeys(chain(products, pairs(solver), grooms(solver), own)))


def quick(solver: str) -> tuple[Case, ...]:
    """The small matrix: pairs of the widest values, a few grooms of just over a block, and of rods pinned tips."""
    table = {axis: labels for axis, labels in QUICK.items() if axis != "start"}
    cases = [Case.of(solver, {**row, "start": start}) for row in covering(table) for start in QUICK["start"]]
    cases += [Case.of(solver, {**row, "strands": "129", "lengths": "unequal"}) for row in covering(QUICK)[:6]]
    cases += [Case.of(solver, {"n": n, "L": L}) for n in SHORT for L in AXES["L"]]
    if solver == "rod":
        cases += [Case.of(solver, {**row, "end": "pinned"}) for row in covering(QUICK)[6:12]]
    return tuple(dict.fromkeys(cases))


def batches(cases: Sequence[Case]) -> list[tuple[Case, ...]]:
    """Cases that differ in the start alone, which are lanes of one block, together; the order stays. Strands that may
    meet each other are grooms of their own."""
    found: dict[tuple[object, ...], list[Case]] = {}
    start = list(AXES).index("start")
    for case in cases:
        alone = case.grouped or case.value("strands") > 1
        key = (case.solver, case.labels if alone else case.labels[:start] + case.labels[start + 1 :])
        found.setdefault(key, []).append(case)
    return [tuple(batch) for batch in found.values()]
