"""Rows of a scratch array, handed out by name with the stages in which each is held.

Kernels that work on a batch keep one number an item and quantity: a row. All rows are in one array, for a compiler that
knows how far apart they are need not fear that they overlap. The same memory serves quantities that are never needed
together; who holds a row and until when is written here, once, and checked when the layout is imported.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence


class RowOverlapError(ValueError):
    """Two quantities would hold one row at the same stage."""


class RowAllocator:
    """Lays out the rows of one scratch array.

    ``pitch``: numbers a row. ``stages``: for each user of the layout, a kernel, the names of its stages in order. Users
    never run at the same time on one array, so each counts for itself. A stage that runs again in a loop reads what the
    loop's end has left: what is carried round has to be held from the loop's first stage to its last.
    """

    def __init__(self, pitch: int, stages: Mapping[str, Sequence[str]]) -> None:
        self.pitch = pitch
        self._stages = {user: tuple(names) for user, names in stages.items()}
        self._held: dict[tuple[int, str, int], str] = {}

    def take(self, name: str, count: int = 1, **held: str) -> tuple[int, ...]:
        """The offsets in numbers of ``count`` neighbouring rows for the quantity ``name``, the lowest that are free.

        ``held``: for each user that needs it the stage in which it does, or the first and the last as "light:shade".
        """
        times = list(self._times(held))
        first = 0
        while any((row, *time) in self._held for row in range(first, first + count) for time in times):
            first += 1
        return self.place(name, first, count, **held)

    def place(self, name: str, row: int, count: int = 1, **held: str) -> tuple[int, ...]:
        """As `take`, from row number ``row`` on. Raises `RowOverlapError` where one of them is held at that time."""
        for user, stage in self._times(held):
            for one in range(row, row + count):
                holder = self._held.setdefault((one, user, stage), name)
                if holder != name:
                    where = f"in stage {self._stages[user][stage]} of {user}"
                    raise RowOverlapError(f"row {one} would hold {name} beside {holder} {where}")
        return tuple(self.pitch * one for one in range(row, row + count))

    def one(self, name: str, **held: str) -> int:
        """The offset of a single row, as `take`."""
        return self.take(name, 1, **held)[0]

    def count(self, user: str) -> int:
        """Rows that a user's array has."""
        return max((row + 1 for row, who, _ in self._held if who == user), default=0)

    def holder(self, row: int, user: str, stage: str) -> str | None:
        """The quantity in a row at a stage."""
        return self._held.get((row, user, self._stage(user, stage)))

    def _stage(self, user: str, name: str) -> int:
        if name not in self._stages[user]:
            raise ValueError(f"{user} has no stage {name}")
        return self._stages[user].index(name)

    def _times(self, held: Mapping[str, str]) -> Iterator[tuple[str, int]]:
        """Users and numbers of the stages that ``held`` names."""
        for user, words in held.items():
            first, _, last = words.partition(":")
            begin, end = self._stage(user, first), self._stage(user, last or first)
            if end < begin:
                raise ValueError(f"{user}: stage {last} is before {first}")
            yield from ((user, stage) for stage in range(begin, end + 1))
