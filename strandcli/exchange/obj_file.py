"""Wavefront `.obj` files, which hold meshes, strands, or both: statements, a line each, of words.

They are read by blocks of lines, so that words of all of it never are in memory.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import UsageError, one_line
from .bounded import Bounded, Growing, numbers_of, opened

BLOCK, LONGEST = 1 << 18, 1 << 22
"""Bytes that are read at once, and of a line."""
TABLES = {b"v": 3, b"vt": 2, b"vn": 3}
"""Statements with numbers, in the order in which corners name their rows, and how many numbers they have at least."""
TAKES = {b"f": ("corners", 30), b"l": ("points of its lines", 16)}
"""Statements that name rows of tables: what these are, and bytes of memory that each takes."""
CORNERS = [re.compile(rb"(?:[-+]?\d+%b )*" % (count * rb"/[-+]?\d+")) for count in range(len(TABLES))]
"""How corners are written that name a row of one table, of the first two, and of all, where 0 stands for none."""
CORNER = re.compile(rb"[-+]?\d{1,18}(?:/(?:[-+]?\d{1,18})?){0,2}")
"""A corner that is written in any of these forms, also with slashes that nothing follows."""
MENDS = "write it anew from its program"
Words = list[list[bytes]]


class ObjFile:
    """The numbers of a file, and what the statements ``f`` or ``l`` of it name.

    tables: rows of numbers by statement; colours: (n, 3) of the first vertices, of which ``coloured`` have one; rows:
    (C, tables) the rows, from 1 and 0 for none, that the corners of all statements name; lengths: how many corners
    each statement has.
    """

    def __init__(self, file: Bounded, of: bytes, kind: npt.DTypeLike, colour: Callable[[Any], Any]) -> None:
        """``of``: the statement that counts; ``kind``: type of the numbers; ``colour``: colours of those that a file
        has (n, 3)."""
        self.file, self.of, self._colour = file, of, colour
        self.tables = {name: Growing(kind, TABLES[name]) for name in (TABLES if of == b"f" else (b"v",))}
        self.colours, self.coloured = Growing(np.float32, 3), 0
        self.rows, self.lengths = Growing(np.int32, len(self.tables)), Growing(np.int32)

    def blocks(self) -> Iterator[tuple[list[bytes], Words]]:
        """Read the file, some lines at once: the first words of all lines, and all words of each."""
        line = 1
        for lines in blocks(self.file):
            words = [one.split() for one in lines]
            heads = [one[0] if one else b"" for one in words]
            self._add_rows(heads, words, line)
            for name in self.tables:
                self._add_numbers(name, [one[1:] for head, one in zip(heads, words, strict=True) if head == name],
                                  words, line)  # fmt: skip
            field, each = TAKES[self.of]
            self.file.room(field, self.rows.size, each)
            yield heads, words
            line += len(lines)
        self._check()

    def fault(self, line: int, words: str) -> UsageError:
        """An error about a line."""
        return UsageError(f"{self.file.path}: line {line:,}: {words}: {MENDS}")

    def _add_rows(self, heads: list[bytes], lines: Words, line: int) -> None:
        own = [k for k, head in enumerate(heads) if head == self.of]
        words = [word for k in own for word in lines[k][1:]]
        lengths = np.array([len(lines[k]) - 1 for k in own], np.int32)
        corners, bad = _corners(words)
        corners = corners[:, : len(self.tables)]
        named = corners != 0
        if bad is None and (corners < 0).any():  # they count back from their line
            for column, name in enumerate(self.tables):
                before = self.tables[name].size + np.cumsum([head == name for head in heads])
                back = corners[:, column] < 0
                corners[back, column] += (np.repeat(before[own], lengths)[back] + 1).astype(np.int32)
        wrong = np.flatnonzero((corners < 0).any(axis=1) | (named & (corners == 0)).any(axis=1) | (corners[:, 0] == 0))
        if wrong.size or bad is not None:
            first = int(wrong[0]) if bad is None else bad
            at = line + own[int(np.searchsorted(np.cumsum(lengths), first, side="right"))]
            why = "indices count from 1" if bad is None else "is no corner, such as 1, 1/1, 1//1 or 1/1/1"
            raise self.fault(at, f"'{_shown(words[first])}': {why}")
        self.rows.add(corners)
        self.lengths.add(lengths)

    def _add_numbers(self, name: bytes, rows: Words, lines: Words, line: int) -> None:
        if not rows:
            return
        least, table = TABLES[name], self.tables[name]
        values = _numbers(rows, least)
        if values is None:
            own = ((line + k, words[1:]) for k, words in enumerate(lines) if words and words[0] == name)
            at, words = next(one for one in own if _numbers([one[1]], least) is None)
            few = f"of {len(words)} numbers, {least} are needed"
            why = few if len(words) < least else f"with what is no number: '{_shown(b' '.join(words))}'"
            raise self.fault(at, f"'{name.decode()}' {why}")
        with np.errstate(over="ignore"):
            if name == b"v":
                self.coloured += sum(len(row) >= 6 for row in rows)
                if values.shape[1] >= 6 and self.colours.size == table.size:
                    self.colours.add(self._colour(values[:, 3:6]))
            table.add(values[:, :least])

    def _check(self) -> None:
        """Raise where a statement names a row that there is not."""
        for column, (name, table) in enumerate(self.tables.items()):
            most = int(self.rows.rows[:, column].max(initial=0))
            if most > table.size:
                place = np.searchsorted(np.cumsum(self.lengths.rows), self.rows.rows[:, column].argmax(), side="right")
                at, of = line_of(self.file.path, self.of, int(place)), self.of.decode()
                raise self.fault(at, f"'{of}' wants '{name.decode()}' {most:,} of {table.size:,}")


def _corners(words: list[bytes]) -> tuple[npt.NDArray[np.int32], int | None]:
    """Corners (C, 3) as they are written, and the number of the first word that is none."""
    text = b" ".join(words).replace(b"//", b"/0/") + b" "
    corners = np.zeros((len(words), len(TABLES)), np.int32)
    for count, pattern in enumerate(CORNERS, 1):
        if pattern.fullmatch(text):
            values = np.fromstring(text.replace(b"/", b" "), np.int64, sep=" ").reshape(-1, count)
            corners[:, :count] = np.clip(values, -(2**31), 2**31 - 1)
            return corners, None
    for k, word in enumerate(words):  # each its own form
        if not CORNER.fullmatch(word):
            return corners[:k], k
        parts = [int(part) if part else 0 for part in word.split(b"/")]
        corners[k, : len(parts)] = np.clip(parts, -(2**31), 2**31 - 1)
    return corners, None


def _numbers(rows: Words, least: int) -> npt.NDArray[np.float64] | None:
    """Rows of numbers (n, k), as many of each as the shortest has; None where those are too few, or no numbers."""
    width = min(map(len, rows))
    if width < least:
        return None
    found = numbers_of(b" ".join([b" ".join(row[:width]) for row in rows]))
    return None if found is None or found.size != len(rows) * width else found.reshape(len(rows), width)


def _shown(words: bytes) -> str:
    """Words of a file for a message."""
    return one_line(words[:40].decode("utf-8", "replace"))


def blocks(file: Bounded) -> Iterator[list[bytes]]:
    """Lines, some at once; those that end in a backslash go on in the next one."""
    for whole in file.blocks("line", BLOCK, LONGEST, _last_end):
        yield whole.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ").splitlines()


def _last_end(content: bytes) -> int:
    """Where the last whole line ends."""
    end = content.rfind(b"\n") + 1
    while end and (content[end - 2 : end - 1] == b"\\" or content[end - 3 : end - 1] == b"\\\r"):
        end = content.rfind(b"\n", 0, end - 1) + 1
    return end


def line_of(path: Path, name: bytes, number: int) -> int:
    """The line of a statement, of which there are so many of that name before it; 0 of none."""
    line = 1
    with opened(path, ".obj file") as file:
        for lines in blocks(file):
            places = [k for k, words in enumerate(lines) if words.split(None, 1)[:1] == [name]]
            if number < len(places):
                return line + places[number]
            number -= len(places)
            line += len(lines)
    return 0
