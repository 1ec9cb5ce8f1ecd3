"""Allocator for the rows of a scratch array, in which quantities share memory that are never live together.

A kernel that works on a batch keeps a row for each quantity, one number an item. All rows are in one array at constant
offsets, so the compiler knows that they do not overlap. A lifetime is a range of stages, declared where the row is
allocated.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence


class RowAllocator:
    """Allocates the rows of one scratch array.

    ``pitch``: numbers a row. ``stages``: for each user of the layout, the names of its stages in order. A user is a
    group of kernels; two users never work on one array at the same time, so their lifetimes are independent. Where
    stages run in a loop, a quantity that is carried from one turn to the next lives from the first stage of the loop to
    the last.
    """

    def __init__(self, pitch: int, stages: Mapping[str, Sequence[str]]) -> None:
        self.pitch = pitch
        self._stages = {user: tuple(names) for user, names in stages.items()}
        self._taken: set[tuple[int, str, int]] = set()
        """Row, user and number of the stage."""

    def allocate(self, count: int = 1, **lifetime: str) -> tuple[int, ...]:
        """Return the offsets, in numbers, of the first ``count`` consecutive rows that are free for a quantity.

        ``lifetime``: for each user that needs the quantity a stage, or the first and the last one as "light:shade".
        Raises `ValueError` if a stage does not exist.
        """
        stages = list(self._stages_of(lifetime))
        first = 0
        while any((row, *stage) in self._taken for row in range(first, first + count) for stage in stages):
            first += 1
        self._taken.update((row, *stage) for row in range(first, first + count) for stage in stages)
        return tuple(self.pitch * row for row in range(first, first + count))

    def row_count(self, user: str) -> int:
        """Return the number of rows that a user's array needs."""
        return max((row + 1 for row, who, _ in self._taken if who == user), default=0)

    def _stages_of(self, lifetime: Mapping[str, str]) -> Iterator[tuple[str, int]]:
        """Yield user and stage number for each stage of a lifetime."""
        for user, stages in lifetime.items():
            first, _, last = stages.partition(":")
            begin, end = self._stages[user].index(first), self._stages[user].index(last or first)
            yield from ((user, stage) for stage in range(begin, end + 1))
