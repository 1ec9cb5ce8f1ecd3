"""Pairwise covering: a few rows in which every two values of any two axes meet at least once.

Faults of several axes at once are mostly faults of two of them (Kuhn, Wallace & Gallo 2004), and pairs need hundreds of
times fewer rows than the full product.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

Row = dict[str, str]
Pair = tuple[str, str, str, str]


def pairs_of(row: Mapping[str, str]) -> set[Pair]:
    """Every (axis, value, axis, value) of a row, axes in the row's own order."""
    return {(a, row[a], b, row[b]) for a, b in combinations(row, 2)}


def all_pairs(axes: Mapping[str, Sequence[str]]) -> dict[Pair, None]:
    """Every pair that has to be covered, in a fixed order."""
    return {(a, x, b, y): None for a, b in combinations(axes, 2) for x in axes[a] for y in axes[b]}


def covering(axes: Mapping[str, Sequence[str]]) -> list[Row]:
    """Rows that cover every pair of values, greedily: each row begins with the first pair that is still open, and
    takes, axis by axis, the value that closes most open pairs with what the row holds already. No randomness."""
    open_pairs = all_pairs(axes)
    rows: list[Row] = []
    turn = dict.fromkeys(axes, 0)
    while open_pairs:
        a, x, b, y = next(iter(open_pairs))
        chosen = {a: x, b: y}
        # axes of many values first: they are the hardest to satisfy
        for axis in sorted(axes, key=lambda name: -len(axes[name])):
            if axis not in chosen:
                chosen[axis] = _best(axis, axes, chosen, open_pairs, turn)
        row = {axis: chosen[axis] for axis in axes}
        rows.append(row)
        for pair in pairs_of(row):
            open_pairs.pop(pair, None)
    if not rows and axes:  # a single axis has no pairs
        rows = [dict.fromkeys(axes, value) for value in next(iter(axes.values()))]
    return rows


def _best(
    axis: str, axes: Mapping[str, Sequence[str]], chosen: Row, open_pairs: Mapping[Pair, None], turn: dict[str, int]
) -> str:
    """The value that closes most; of equal ones each in its turn, so that free axes do not rest at one value."""
    order = list(axes)
    place = order.index(axis)

    def closes(value: str) -> int:
        return sum(
            ((axis, value, other, has) if place < order.index(other) else (other, has, axis, value)) in open_pairs
            for other, has in chosen.items()
        )

    values = axes[axis]
    gains = [closes(value) for value in values]
    best = [value for value, gain in zip(values, gains, strict=True) if gain == max(gains)]
    turn[axis] += 1
    return best[turn[axis] % len(best)]
