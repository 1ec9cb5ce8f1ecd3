"""Allocator for the rows of a scratch array, which checks that quantities that share a row are never live together.

A kernel that works on a batch keeps a row for each quantity, one number an item. All rows are in one array at constant
offsets, so the compiler knows that they do not overlap. Quantities whose lifetimes are disjoint share memory. A
lifetime is a range of stages, declared where the row is allocated and checked when the layout is imported.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence


class RowOverlapError(ValueError):
    """Two quantities would occupy one row in the same stage."""


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
        self._holders: dict[tuple[int, str, int], str] = {}

    def allocate(self, name: str, count: int = 1, **lifetime: str) -> tuple[int, ...]:
        """Return the offsets, in numbers, of the first ``count`` consecutive rows that are free for the quantity.

        ``lifetime``: for each user that needs the quantity a stage, or the first and the last one as "light:shade".
        """
        stages = list(self._stages_of(lifetime))
        first = 0
        while any((row, *stage) in self._holders for row in range(first, first + count) for stage in stages):
            first += 1
        return self.allocate_at(name, first, count, **lifetime)

    def allocate_at(self, name: str, first: int, count: int = 1, **lifetime: str) -> tuple[int, ...]:
        """Return offsets as `allocate` does, of the rows from number ``first`` on.

        Raises `RowOverlapError` if another quantity occupies one of them during the lifetime.
        """
        for user, stage in self._stages_of(lifetime):
            for row in range(first, first + count):
                holder = self._holders.setdefault((row, user, stage), name)
                if holder != name:
                    where = f"in stage {self._stages[user][stage]} of {user}"
                    raise RowOverlapError(f"row {row} would hold {name} beside {holder} {where}")
        return tuple(self.pitch * row for row in range(first, first + count))

    def allocate_row(self, name: str, **lifetime: str) -> int:
        """Return the offset of a single row, as `allocate` does."""
        return self.allocate(name, 1, **lifetime)[0]

    def row_count(self, user: str) -> int:
        """Return the number of rows that a user's array needs."""
        return max((row + 1 for row, who, _ in self._holders if who == user), default=0)

    def holder(self, row: int, user: str, stage: str) -> str | None:
        """Return the name of the quantity in a row at a stage, None if it is free."""
        return self._holders.get((row, user, self._stage(user, stage)))

    def _stage(self, user: str, name: str) -> int:
        """Return the number of a user's stage. Raises `ValueError` if there is none of this name."""
        if name not in self._stages[user]:
            raise ValueError(f"{user} has no stage {name}")
        return self._stages[user].index(name)

    def _stages_of(self, lifetime: Mapping[str, str]) -> Iterator[tuple[str, int]]:
        """Yield user and stage number for each stage of a lifetime.

        Raises `ValueError` if a stage does not exist, or the last is before the first.
        """
        for user, stages in lifetime.items():
            first, _, last = stages.partition(":")
            begin, end = self._stage(user, first), self._stage(user, last or first)
            if end < begin:
                raise ValueError(f"{user}: stage {last} is before {first}")
            yield from ((user, stage) for stage in range(begin, end + 1))
