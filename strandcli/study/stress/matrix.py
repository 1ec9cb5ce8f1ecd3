"""Which cases are run: full products for one strand, sheet by sheet, and pairs of everything for the rest.

The product of all axes has tens of millions of cases. In full, for one strand, with every step length and every start:
what moves it (rigidity, weight, wind, emitter); what it touches (contact, rigidity, wind, emitter); what measures it
(segments, length, place, tapering); substeps with rigidity and weight. Beyond these, pairs of every axis with every
other, long strands included, for one strand and for grooms; of rods every combination of what strands do to each other,
twist by and are pinned by meets pairs of the other axes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from itertools import chain, combinations, product

from .axes import AXES, GROUPED, Case, refusal

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


def values(axis: str) -> tuple[str, ...]:
    """Labels of an axis."""
    return tuple(AXES[axis])


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


def product_of(solver: str, axes: Mapping[str, Sequence[str]]) -> Iterator[Case]:
    """One strand: every combination of these axes, the rest at their defaults."""
    for labels in product(*(taken or values(axis) for axis, taken in axes.items())):
        yield Case.of(solver, dict(zip(axes, labels, strict=True)))


def pairs(solver: str) -> Iterator[Case]:
    """One strand: pairs of all axes, each row from every start, which costs nothing more."""
    for row in covering({axis: values(axis) for axis in ALONE}):
        for start in values("start"):
            yield Case.of(solver, {**row, "start": start})


def grooms(solver: str) -> Iterator[Case]:
    """Many strands: pairs of all axes, for short strands and for long ones with few of them."""
    table = {axis: values(axis) for axis in AXES if axis not in ("collide", *GROUPED)}
    table |= {"strands": ("2", "129", "700"), "n": (*SHORT, "32")}
    for row in covering(table):
        yield Case.of(solver, row)


def segments() -> Iterator[Case]:
    """Rods: random strands whose whole segments are kept out of spheres, and not their particles alone."""
    for contact, n in product(("inside", "through", "small", "moving"), ("3", "10")):
        yield Case.of("rod", {"contact": contact, "n": n, "strands": "129", "start": "random", "collide": "segments"})


def groups() -> Iterator[Case]:
    """Rods: pairs of the axes of `BESIDE` for every combination of what strands do to each other, twist by, and are
    pinned by."""
    rows = covering({axis: taken or values(axis) for axis, taken in BESIDE.items()})
    for between, twist, end in product(values("between"), values("twist"), values("end")):
        for row in rows:
            case = Case.of("rod", {**row, "between": between, "twist": twist, "end": end})
            if not refusal(case):
                yield case


@cache
def full(solver: str) -> tuple[Case, ...]:
    """The whole matrix of one solver, each case once."""
    products = chain.from_iterable(product_of(solver, axes) for axes in SHEETS.values())
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
