"""The frames that a person asks for: ``1-48``, ``1-100x5,120``."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ..errors import UsageError

_PART = re.compile(r"([0-9]{1,18})(?:-([0-9]{1,18})(?:x([0-9]{1,18}))?)?")
MOST_PARTS = 10_000


@dataclass(frozen=True, slots=True)
class FrameRange:
    """A set of frame numbers, kept as ranges so that a mistyped ``1-9999999`` costs nothing."""

    parts: tuple[range, ...]

    @classmethod
    def parse(cls, text: str) -> FrameRange:
        """Read comma-separated parts, each ``N``, ``FIRST-LAST`` or ``FIRST-LASTxSTEP``; both ends belong to a range.

        Raises ``ValueError`` with a message that names the part at fault.
        """
        words = [word.strip() for word in text.split(",")]
        if len(words) > MOST_PARTS:
            raise ValueError(f"more than {MOST_PARTS} comma-separated parts")
        return cls(tuple(_part(word) for word in words))

    @property
    def last(self) -> int:
        """The highest frame number."""
        return max(part[-1] for part in self.parts)

    def numbers(self) -> tuple[int, ...]:
        """Every frame once, in ascending order, however they were written."""
        if len(self.parts) == 1:
            return tuple(self.parts[0])
        found: set[int] = set()
        for part in self.parts:
            found.update(part)
        return tuple(sorted(found))

    def within(self, total: int) -> tuple[int, ...]:
        """The frame numbers, for an animation of ``total`` frames; ``UsageError`` if one lies beyond its end."""
        if self.last > total:
            frames = "only frame 1" if total == 1 else f"frames 1 to {total}"
            raise UsageError(
                f"-f/--frames asks for frame {self.last}, but the animation has {frames}; "
                f"for more, add --set time.frames={self.last}"
            )
        return self.numbers()


def _part(word: str) -> range:
    match = _PART.fullmatch(word)
    if match is None:
        raise ValueError(f"'{word}' is not a frame (12), a range (1-48) or a stepped range (1-100x5)")
    first = int(match[1])
    last = int(match[2]) if match[2] is not None else first
    step = int(match[3]) if match[3] is not None else 1
    if first < 1:
        raise ValueError(f"'{word}': frames are counted from 1")
    if last < first:
        raise ValueError(f"'{word}' runs backwards; write {last}-{first}")
    if step < 1:
        raise ValueError(f"'{word}': the step after x is at least 1")
    return range(first, last + 1, step)
