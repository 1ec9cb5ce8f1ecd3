"""What is wrong with a preset, where, and what was probably meant.

All faults of a preset are gathered before any is reported, so that a person mends a file once and not once a fault.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from ..errors import UsageError, one_line

LONGEST_SHOWN = 60
_ALIKE = 0.55  # of 1; difflib's own 0.6 does not take "boks" for "box"


OPTIONS = ("--set", "--sweep", "set", "overrides")
"""What settings of the command line and of Python follow, in the places of faults."""


class Mark(NamedTuple):
    """A place in a file, counted from 1. Line 0 means that ``file`` names a place that has no lines (``--set a=b``)."""

    file: str
    line: int = 0
    column: int = 0


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing that is wrong. ``path`` is the dotted path of the setting, as ``--set`` takes it; it may be empty."""

    file: str
    line: int
    column: int
    path: str
    message: str

    @property
    def mark(self) -> Mark:
        """The place alone."""
        return Mark(self.file, self.line, self.column)

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}:{self.column}" if self.line else self.file
        # "--set wind.strenght=3" already says the path
        path = (
            ""
            if not self.line and self.file.startswith(tuple(f"{option} {self.path}=" for option in OPTIONS))
            else self.path
        )
        return ": ".join(one_line(part) for part in (place, path, self.message) if part)


class Finding(NamedTuple):
    """Something wrong between settings.

    ``places`` are the paths to report it at: the first of them that was written, or around the first where none was.
    ``involves`` are all the paths that it follows from, where these are more; where one of them is faulty, it may
    not be so.
    """

    places: tuple[str, ...]
    message: str
    involves: tuple[str, ...] = ()


class SceneError(UsageError):
    """A preset that cannot be used (exit code 2). ``faults`` holds every fault, ``str`` gives one line for each."""

    def __init__(self, faults: Iterable[Fault]) -> None:
        self.faults: tuple[Fault, ...] = tuple(faults)
        super().__init__("\n".join(str(fault) for fault in self.faults))

    def __reduce__(self) -> tuple[type[SceneError], tuple[tuple[Fault, ...]]]:
        return SceneError, (self.faults,)


def fault_at(mark: Mark, path: str, message: str) -> Fault:
    """The fault with this message at ``mark``."""
    return Fault(mark.file, mark.line, mark.column, path, message)


def shown(text: str) -> str:
    """``text`` as messages quote it: one line, cut where it is long."""
    cut = text if len(text) <= LONGEST_SHOWN else text[: LONGEST_SHOWN - 3] + "..."
    return f"'{one_line(cut)}'"


def near(word: str, known: Iterable[str]) -> str | None:
    """The known word that ``word`` was probably meant to be, or None."""
    if not word or len(word) > LONGEST_SHOWN:  # difflib takes quadratic time
        return None
    from difflib import get_close_matches

    names = list(known)
    found = get_close_matches(word, names, 1, _ALIKE) or get_close_matches(word.lower(), names, 1, _ALIKE)
    return found[0] if found else None


def hint(word: str, known: Iterable[str], what: str) -> str:
    """The end of a message about an unknown word: what was probably meant, else all ``known`` words.

    ``what`` introduces the list, as in "the keys are".
    """
    names = list(known)
    guess = near(word, names)
    if guess is not None:
        return f"did you mean {shown(guess)}?"
    return f"{what} {', '.join(names)}" if names else f"{what} none"
