"""What every kind of setting is: its default and meaning, its limits, how its value is read, and its part of the JSON
Schema.

YAML 1.1 and 1.2 readers disagree on much (`010`, `1_000`, `12:30`, `no`). Values are asked for by type, never guessed,
and whatever two readers would take for different values is refused with the reason.
"""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any, NamedTuple

from ..faults import shown
from ..nodes import Node, Scalar, given

if TYPE_CHECKING:
    from ..schema import Writer
    from ..validate import Reader

Json = dict[str, Any]

LARGEST = 1e9
"""Greatest magnitude of any number: squares and cubes of it still fit the single precision of the kernels."""
SMALLEST = 1e-9
"""Least positive number where zero is excluded; its square is still a normal number in single precision."""
WORD: Json = {"type": ["string", "number", "boolean"]}
_NUMBER = re.compile(r"[-+]?(?:\.[0-9]+|(?:0|[1-9][0-9]*)(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?")
_DISPUTED = re.compile(r"[-+]?[0-9][0-9a-fox_:,.]*", re.IGNORECASE)
"""Looks like a number to some: octal, base 60, with a comma; YAML readers disagree."""
_NOT_FINITE = re.compile(r"[-+]?\.?(?:inf|infinity|nan)", re.IGNORECASE)
_LONGEST_NUMBER = 400


class Refusal(ValueError):
    """A value that is not what was asked for; the message says why, as in "not '12:30'"."""


def as_number(scalar: Scalar) -> int | float:
    """A finite number. Raises Refusal."""
    text = scalar.text
    short = len(text) <= _LONGEST_NUMBER
    if scalar.plain and short and _NUMBER.fullmatch(text):
        value = float(text) if {*text.lower()} & {".", "e"} else int(text)
        if value in (math.inf, -math.inf):
            raise Refusal(f"not {shown(text)}, which is too large for a number")
        return value
    if not scalar.plain:
        raise Refusal(f"not the text {shown(text)}" + ("; take the quotes away" if _NUMBER.fullmatch(text) else ""))
    why = "; it must be finite" if _NOT_FINITE.fullmatch(text) else ""
    if short and _DISPUTED.fullmatch(text):
        why = ", which YAML readers disagree about; write it as 1000 or 0.5"
    raise Refusal(f"not {shown(text)}{why}")


class Range(NamedTuple):
    """What a number may be: ``low`` and ``high`` may be reached, ``above`` and ``below`` may not; None is no limit."""

    low: float | None = None
    above: float | None = None
    below: float | None = None
    high: float | None = None

    def holds(self, value: float) -> bool:
        """Whether ``value`` (finite) is allowed."""
        if abs(value) > max(LARGEST, abs(self.high or 0.0)) or (self.above == 0 and value < SMALLEST):
            return False
        return self.spans(value)

    def spans(self, value: float) -> bool:
        """Whether ``value`` is within the limits, whatever single precision can hold."""
        return (
            (self.low is None or value >= self.low)
            and (self.above is None or value > self.above)
            and (self.below is None or value < self.below)
            and (self.high is None or value <= self.high)
        )

    def number(self, node: Node) -> int | float:
        """The number of a node. Raises `Refusal`."""
        if not isinstance(node, Scalar) or node.empty or node.null:
            raise Refusal(f"not {given(node)}")
        value = as_number(node)
        if not self.holds(value):
            beyond = "; single precision ends before that" if self.spans(value) else ""
            raise Refusal(f"not {shown(node.text)}{beyond}")
        return value

    def whole(self, node: Node) -> int:
        """The whole number of a node. Raises `Refusal`."""
        value = self.number(node)
        if isinstance(value, float) and not value.is_integer():
            raise Refusal(f"not {given(node)}")
        return int(value)

    def schema(self, kind: str) -> Json:
        """The JSON Schema of a number."""
        words = ("minimum", "exclusiveMinimum", "exclusiveMaximum", "maximum")
        return {"type": kind, **{word: limit for word, limit in zip(words, self, strict=True) if limit is not None}}

    def __str__(self) -> str:
        parts = (("of at least", self.low), ("above", self.above), ("below", self.below), ("of at most", self.high))
        # a limit that is no whole number in Python's eyes is written as a person would: 1e+13
        return " and ".join(
            f"{word} {limit:.12g}" if isinstance(limit, float) else f"{word} {limit}"
            for word, limit in parts
            if limit is not None
        )


def in_unit(unit: str) -> str:
    """A unit in brackets after a space; "" for none."""
    return f" ({unit})" if unit and unit != "1" else ""


class Spec:
    """What every setting has: its value where none is written, what it means, in which unit, and within which limits.

    Specs are plain classes: made at every start, dataclasses of them would take 20 ms.
    """

    type_name, words = "mapping", "a mapping of settings"
    """What it takes, in the reference and in messages."""

    def __init__(self, default: Any = None, *, doc: str = "", unit: str = "", **limits: float | None) -> None:
        """``limits``: of `Range`."""
        self.default = default
        self.doc = doc
        self.unit = unit
        self.limits = Range(**limits)

    def wanted(self) -> str:
        """What it takes, as it follows "must be" in messages: "a number above 0 (m)"."""
        return f"{self.words} {self.limits}".rstrip() + in_unit(self.unit)

    def read(self, reader: Reader, node: Node, path: str) -> Any:
        """The value of a node, of which faults inside are noted by the reader. Raises `Refusal`."""
        if not isinstance(node, Scalar) or node.empty:
            raise Refusal(f"not {given(node)}")
        return self.scalar(node)

    def scalar(self, node: Scalar) -> Any:
        """The value of a single value. Raises `Refusal`."""
        raise NotImplementedError

    def schema(self, writer: Writer) -> Json:
        """The JSON Schema of what it takes, but for null."""
        return dict(WORD)
