"""Values of options: frames, errors, steps, lists, kinds of animation and layers, angles, sizes of pictures."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import click
from click.shell_completion import CompletionItem

from ..errors import UsageError
from .completion import listed

MOST_PIXELS = 32_768
"""Along a side of a picture."""
KINDS = ("gif", "webp", "mp4")
"""Animations that can be written."""
BOUNDS = ("motion", "picture", "flip")
"""What `render --max-error` bounds: where strands are, light in the picture, and what the eye sees of that. The first
is meant where none is named."""

_PART = re.compile(r"([0-9]{1,18})(?:-([0-9]{1,18})(?:x([0-9]{1,18}))?)?")
_DECIMAL = r"[0-9]*\.?[0-9]+(?:[eE][-+]?[0-9]{1,3})?"
MOST_PARTS = 10_000


class Parsed(click.ParamType):
    """What a function reads of a text; its ``ValueError`` says what is wrong."""

    def __init__(self, name: str, read: Callable[[str], Any], choices: Sequence[str] = ()) -> None:
        """``choices``: words that a shell offers, for a list with commas in between."""
        self.name, self.read, self.choices = name, read, choices

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if not isinstance(value, str):  # as click hands in what it has converted
            return value
        try:
            return self.read(value)
        except ValueError as error:
            self.fail(str(error), param, ctx)

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        return listed(self.choices, incomplete)


@dataclass(frozen=True, slots=True)
class FrameRange:
    """A set of frame numbers, stored as ranges so that a mistyped ``1-9999999`` costs nothing."""

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
        return tuple(sorted(set().union(*self.parts)))

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
    first, last, step = int(match[1]), int(match[2] or match[1]), int(match[3] or 1)
    if first < 1:
        raise ValueError(f"'{word}': frames are counted from 1")
    return stepped(word, first, last, step)


def stepped(word: str, first: int, last: int, step: int) -> range:
    """The numbers of a range, its ends among them. Raises ``ValueError``."""
    if last < first:
        raise ValueError(f"'{word}' runs backwards; write {last}-{first}")
    if step < 1:
        raise ValueError(f"'{word}': the step after x is at least 1")
    return range(first, last + 1, step)


def error_share(text: str) -> float:
    """An error as a share: ``1%`` or ``0.01``."""
    match = re.fullmatch(rf"\s*({_DECIMAL})\s*(%?)\s*", text, re.ASCII)
    if match is None:
        raise ValueError(f"'{text}' is not an error, such as 1% or 0.01")
    share = float(match[1]) / (100 if match[2] else 1)
    if not 0 < share <= 1:
        raise ValueError(f"'{text}': an error is more than 0 and at most 100%")
    return share


def bounds(text: str) -> dict[str, float]:
    """Errors by what they are of: ``1%`` (of motion), ``picture=2%``, ``motion=1%,flip=0.05``."""
    found: dict[str, float] = {}
    for word in text.split(","):
        name, given, error = word.rpartition("=")
        name = name.strip() if given else BOUNDS[0]
        if name not in BOUNDS:
            raise ValueError(f"'{name}' has no error; write {', '.join(f'{one}=2%' for one in BOUNDS)}")
        if name in found:
            raise ValueError(f"'{text}' names two errors of {name}")
        found[name] = error_share(error)
    return found


def several(name: str, read: Callable[[str], Any], example: str) -> Parsed:
    """Values separated by commas."""

    def read_all(text: str) -> tuple[Any, ...]:
        try:
            return tuple(dict.fromkeys(read(word.strip()) for word in text.split(",")))
        except ValueError as error:
            raise ValueError(f"{error}; write for instance {example}") from None

    return Parsed(name, read_all)


def kinds(text: str) -> tuple[str, ...]:
    """Kinds of animation, separated by commas."""
    found = tuple(dict.fromkeys(word.strip().lower().lstrip(".") for word in text.split(",")))
    for kind in found:
        if kind not in KINDS:
            raise ValueError(f"'{kind}' is not an animation that can be written; choose gif, webp, mp4, or several")
    return found


def layers(text: str) -> tuple[str, ...]:
    """Names of layers, separated by commas."""
    names = tuple(word.strip() for word in text.split(","))
    if not all(names):
        raise ValueError(f"'{text}' is not a list of layers such as depth,mask")
    from ..scene.faults import hint, shown
    from ..scene.model import AOVS

    for place, name in enumerate(names):
        if name not in AOVS:
            raise ValueError(f"unknown layer {shown(name)}; {hint(name, AOVS, 'the layers are')}")
        if name in names[:place]:
            raise ValueError(f"the layer {shown(name)} is listed twice")
    return names


def count(low: int, high: int) -> Callable[[str], int]:
    """A reader of whole numbers in a range."""

    def read(word: str) -> int:
        if not re.fullmatch(r"[0-9]{1,9}", word, re.ASCII) or not low <= int(word) <= high:
            raise ValueError(f"'{word}' is not a whole number from {low} to {high}")
        return int(word)

    return read


def quantity(what: str, low: float, high: float) -> Callable[[str], float]:
    """A reader of numbers and of fractions such as ``1/240`` in a range."""

    def read(word: str) -> float:
        match = re.fullmatch(rf"({_DECIMAL})(?:/({_DECIMAL}))?", word, re.ASCII)
        below = float(match[2] or 1) if match else 0.0
        found = float(match[1]) / below if match and below > 0 else math.nan
        if not low <= found <= high:
            raise ValueError(f"'{word}' is not {what}")
        return found

    return read


step = quantity("a step from 1e-6 to 10 seconds", 1e-6, 10.0)
metres = quantity("a length above 0, metres", 1e-300, 1e300)


def word(text: str) -> str:
    """A name."""
    if not text:
        raise ValueError("an empty name")
    return text


def span(most: float) -> Parsed:
    """Two angles in degrees, the lesser first, neither beyond ``most``: ``-30,45``."""

    def read(text: str) -> tuple[float, float]:
        try:
            low, high = (float(one) for one in text.split(","))
        except ValueError:
            low, high = 1.0, 0.0
        if not -most <= low <= high <= most:
            words = f"'{text}' is not two angles in degrees, the lesser first, such as -30,45"
            raise ValueError(f"{words}, within {-most:g} and {most:g}")
        return low, high

    return Parsed("A,B", read)


def colour(text: str) -> tuple[int, ...]:
    """A colour of sRGB, ``#rrggbb`` or a name of CSS such as ``white``, as three numbers of 8 bits."""
    from PIL import ImageColor

    found: tuple[int, ...] = ()
    with suppress(ValueError):
        found = ImageColor.getrgb(text.strip())
    if len(found) != 3:
        raise ValueError(f"'{text}' is not a colour, such as white or '#3060a0' in quotes")
    return found


def picture_size(text: str) -> tuple[int, int]:
    """A picture's size, ``800x600``, as (width, height)."""
    match = re.fullmatch(r"\s*([0-9]{1,9})\s*[xX×]\s*([0-9]{1,9})\s*", text, re.ASCII)
    if match is None:
        raise ValueError(f"'{text}' is not a width and a height in pixels, such as 800x600")
    width, height = int(match[1]), int(match[2])
    if not (1 <= width <= MOST_PIXELS and 1 <= height <= MOST_PIXELS):
        raise ValueError(f"'{text}': width and height are from 1 to {MOST_PIXELS} pixels")
    return width, height


FRAMES = Parsed("frames", FrameRange.parse)
ANIMATIONS = Parsed("KIND", kinds, KINDS)
COLOUR = Parsed("COLOUR", colour)
ERROR = Parsed("ERROR", error_share)
SIZE = Parsed("WxH", picture_size)
