"""Which cases are run: full products for one strand, sheet by sheet, and pairs of everything for the rest.

The product of all axes has tens of millions of cases. In full, for one strand, with every step length and every start:
what moves it (rigidity, weight, wind, emitter); what it touches (contact, rigidity, wind, emitter); what measures it
(segments, length, place, tapering); substeps with rigidity and weight. Beyond these, pairs of every axis with every
other, long strands included, for one strand and for grooms.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from itertools import chain, product

from .axes import AXES, Case
from .covering import covering

SHEETS = {
    "motion": ("dt", "B", "gamma", "wind", "emitter", "start"),
    "contact": ("dt", "B", "wind", "emitter", "contact", "start"),
    "size": ("dt", "n", "L", "offset", "tip", "start"),
    "substeps": ("dt", "substeps", "B", "gamma", "start"),
}
SHORT = ("1", "2", "3", "10")
"""Segments that the full products go up to; pairs take longer strands as well."""
ALONE = tuple(axis for axis in AXES if axis not in ("strands", "lengths", "start"))
QUICK = {
    "dt": ("60Hz", "10", "noisy"), "B": ("0", "1", "1e6"), "gamma": ("0", "7.9", "1e4"), "wind": ("calm", "gale"),
    "emitter": ("still", "flip"), "contact": ("none", "through"), "start": tuple(AXES["start"]),
}  # fmt: skip
"""The small matrix of a test: short strands alone, so that little is compiled."""


def values(axis: str) -> tuple[str, ...]:
    """Labels of an axis."""
    return tuple(AXES[axis])


def product_of(solver: str, axes: Sequence[str]) -> Iterator[Case]:
    """One strand: every combination of these axes, the rest at their defaults."""
    for labels in product(*(SHORT if axis == "n" else values(axis) for axis in axes)):
        yield Case.of(solver, dict(zip(axes, labels, strict=True)))


def pairs(solver: str) -> Iterator[Case]:
    """One strand: pairs of all axes, each row from every start, which costs nothing more."""
    for row in covering({axis: values(axis) for axis in ALONE}):
        for start in values("start"):
            yield Case.of(solver, {**row, "start": start})


def grooms(solver: str) -> Iterator[Case]:
    """Many strands: pairs of all axes, for short strands and for long ones with few of them."""
    table = {axis: values(axis) for axis in AXES}
    table["strands"] = ("2", "129", "700")
    table["n"] = (*SHORT, "32")
    for row in covering(table):
        yield Case.of(solver, row)


@cache
def full(solver: str) -> tuple[Case, ...]:
    """The whole matrix of one solver, each case once."""
    products = chain.from_iterable(product_of(solver, axes) for axes in SHEETS.values())
    return tuple(dict.fromkeys(chain(products, pairs(solver), grooms(solver))))


def quick(solver: str) -> list[Case]:
    """The small matrix: pairs of the widest values, and a few grooms of just over a block."""
    table = {axis: labels for axis, labels in QUICK.items() if axis != "start"}
    cases = [Case.of(solver, {**row, "start": start}) for row in covering(table) for start in QUICK["start"]]
    cases += [Case.of(solver, {**row, "strands": "129", "lengths": "unequal"}) for row in covering(QUICK)[:6]]
    cases += [Case.of(solver, {"n": n, "L": L}) for n in SHORT for L in AXES["L"]]
    return list(dict.fromkeys(cases))


def batches(cases: Sequence[Case]) -> list[list[Case]]:
    """Cases that differ in the start alone, which are lanes of one block, together; the order stays."""
    found: dict[tuple[str, ...], list[Case]] = {}
    for case in cases:
        key = (case.solver, *case.labels[:-1])
        assert list(AXES)[-1] == "start"
        found.setdefault(key, []).append(case)
    return list(found.values())
