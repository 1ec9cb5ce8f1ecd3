"""Statements of `.obj` files, which hold meshes, strands, or both: a line each, of words."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ..errors import UsageError, one_line
from .bounded import Bounded, opened

BLOCK, LONGEST = 1 << 18, 1 << 22
"""Bytes that are read at once, and of a line."""
MENDS = "write it anew from its program"


def blocks(file: Bounded) -> Iterator[list[bytes]]:
    """Lines, some at once; those that end in a backslash go on in the next one."""
    rest = b""
    while file.left:
        content = rest + file.take("lines", min(BLOCK, file.left))
        end = content.rfind(b"\n") + 1
        while end and (content[end - 2 : end - 1] == b"\\" or content[end - 3 : end - 1] == b"\\\r"):
            end = content.rfind(b"\n", 0, end - 1) + 1
        end = end if file.left else len(content)
        whole, rest = content[:end], content[end:]
        if len(rest) > LONGEST:
            raise file.damaged(f"lines: no end of line within {LONGEST:,} bytes")
        yield whole.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ").splitlines()


def numbers(rows: list[list[bytes]], least: int) -> npt.NDArray[np.float64] | None:
    """Rows of numbers (n, k), as many of each as the shortest has; None where those are too few, or no numbers."""
    width = min(map(len, rows))
    if width < least:
        return None
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # of text that is no number
        try:
            found = np.fromstring(b" ".join([b" ".join(row[:width]) for row in rows]), np.float64, sep=" ")
            return found.reshape(len(rows), width)
        except (ValueError, DeprecationWarning):
            return None


def no_numbers(path: Path, name: bytes, least: int, lines: list[list[bytes]], line: int) -> UsageError:
    """The error of the first statement of a name among lines that has not the numbers it needs."""
    those = [(line + k, words[1:]) for k, words in enumerate(lines) if words and words[0] == name]
    at, words = next((one for one in those if numbers([one[1]], least) is None), those[0])
    letters = name.decode()
    if len(words) < least:
        return UsageError(f"{path}: line {at:,}: '{letters}' of {len(words)} numbers, {least} are needed: {MENDS}")
    return UsageError(f"{path}: line {at:,}: '{letters}' with what is no number: '{shown(b' '.join(words))}': {MENDS}")


def shown(words: bytes) -> str:
    """Words of a file for a message."""
    return one_line(words[:40].decode("utf-8", "replace"))


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
