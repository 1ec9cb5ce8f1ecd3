"""`--sweep KEY=VALUES`: values of a setting, their product, and a folder's name for each combination."""

from __future__ import annotations

import hashlib
import itertools
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

MOST_POINTS = 10_000
LONGEST_VALUE, LONGEST_NAME = 24, 100
RANGE = re.compile(r"(-?[0-9]{1,9})-([0-9]{1,9})(?:x([0-9]{1,9}))?")


@dataclass(frozen=True, slots=True)
class Axis:
    """A setting, by its dotted path, and the values that it takes, as `--set` has them."""

    key: str
    values: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Point:
    """One combination: ``settings`` of each axis, KEY=VALUE, and the name of its folder."""

    name: str
    settings: tuple[tuple[str, str], ...]

    def overrides(self) -> tuple[str, ...]:
        """The settings as after --set."""
        return tuple(f"{key}={value}" for key, value in self.settings)


def axis_of(text: str) -> Axis:
    """``wind.strength=1,2,4`` or ``seed=1-8`` or ``seed=1-9x2``; commas in brackets and quotes belong to a value.
    Raises ``ValueError``."""
    key, given, after = text.partition("=")
    if not given or not re.fullmatch(r"\s*[^\s=]+\s*", key):
        raise ValueError(f"'{text}' is not KEY=VALUES, such as wind.strength=1,2,4 or seed=1-8")
    values = []
    for word in split(after):
        if not word:
            raise ValueError(f"'{text}': a value is empty; write for instance {key.strip()}=1,2,4")
        try:
            values += numbers(word)
        except ValueError as error:
            raise ValueError(f"'{text}': {error}") from None
        if len(values) > MOST_POINTS:
            raise ValueError(f"'{text}': more than {MOST_POINTS:,} values")
    return Axis(key.strip(), tuple(dict.fromkeys(values)))


def split(text: str) -> list[str]:
    """Words between commas, where these are in no brackets and no quotes."""
    found, depth, quote, word = [], 0, "", ""
    for c in text:
        if quote:
            quote = "" if c == quote else quote
        elif c in "\"'":
            quote = c
        elif c in "[{(":
            depth += 1
        elif c in "]})":
            depth -= 1
        elif c == "," and depth <= 0:
            found.append(word.strip())
            word = ""
            continue
        word += c
    return [*found, word.strip()]


def numbers(word: str) -> list[str]:
    """The whole numbers of a range, ``1-8`` or ``1-9x2``; anything else alone. Raises ``ValueError``."""
    match = RANGE.fullmatch(word)
    if match is None:
        return [word]
    first, last, step = int(match[1]), int(match[2]), int(match[3] or 1)
    if last < first:
        raise ValueError(f"{word} runs backwards; write {last}-{first}")
    if step < 1:
        raise ValueError(f"{word}: the step after x is at least 1")
    if (last - first) // step >= MOST_POINTS:
        raise ValueError(f"{word}: more than {MOST_POINTS:,} values")
    return [str(number) for number in range(first, last + 1, step)]


def points(axes: Sequence[Axis]) -> list[Point]:
    """All combinations, the last axis varying fastest. Raises ``ValueError`` for too many, or a setting given twice."""
    keys = [axis.key for axis in axes]
    twice = [key for key, count in Counter(keys).items() if count > 1]
    if twice:
        raise ValueError(f"--sweep {twice[0]}=...: is given twice; write all its values after one")
    count = 1
    for axis in axes:
        count *= len(axis.values)
    if count > MOST_POINTS:
        raise ValueError(f"--sweep: {count:,} combinations; at most {MOST_POINTS:,} are drawn in one go")
    short = {key: key if [one.rpartition(".")[2] for one in keys].count(key.rpartition(".")[2]) > 1
             else key.rpartition(".")[2] for key in keys}  # fmt: skip
    found = []
    for values in itertools.product(*(axis.values for axis in axes)):
        settings = tuple(zip(keys, values, strict=True))
        found.append((_name(settings, short), settings))
    names = Counter(name.casefold() for name, _ in found)
    return [Point(_distinct(name, settings) if names[name.casefold()] > 1 else name, settings)
            for name, settings in found]  # fmt: skip


def _name(settings: tuple[tuple[str, str], ...], short: dict[str, str]) -> str:
    """A name for a folder that every file system takes and that says what is different; with a hash of the settings
    where it does not say all."""
    plain = "-".join(f"{short[key]}_{value}" for key, value in settings)
    parts = [f"{_safe(short[key])}_{_safe(value)[:LONGEST_VALUE]}" for key, value in settings]
    name = "-".join(parts)[:LONGEST_NAME].strip(".-")
    return name if name == plain else _distinct(name, settings)


def _distinct(name: str, settings: tuple[tuple[str, str], ...]) -> str:
    digest = hashlib.sha256(repr(settings).encode("utf-8", "surrogatepass")).hexdigest()[:8]
    return f"{name}-{digest}".lstrip("-")


def _safe(text: str) -> str:
    return re.sub(r"[^\w.+-]+", "-", text, flags=re.ASCII).strip("-")
