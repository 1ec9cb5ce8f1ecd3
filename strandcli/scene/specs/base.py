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
_DECIMAL = re.compile(r"[-+]?[0-9]+")
_FLOAT = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?")
_HEX = re.compile(r"0x[0-9a-fA-F]+")
_OCTAL = re.compile(r"0o[0-7]+")
_LEADING_ZERO = re.compile(r"[-+]?0+[0-9]+")
_UNDERSCORES = re.compile(r"[-+]?[0-9][0-9_.]*_[0-9_.]*(?:[eE][-+]?[0-9]+)?|0[xo][0-9a-fA-F_]+")
_BASE_60 = re.compile(r"[-+]?[0-9]+(?::[0-9]+)+(?:\.[0-9]*)?")
_COMMA = re.compile(r"([-+]?[0-9]+),([0-9]+)")
_NOT_FINITE = re.compile(r"[-+]?\.?(?:inf|infinity|nan)", re.IGNORECASE)
_LONGEST_INTEGER = 40
_LONGEST_NUMBER = 400


class Refusal(ValueError):
    """A value that is not what was asked for; the message says why, as in "not '12:30'"."""


def as_number(scalar: Scalar) -> int | float:
    """A finite number. Raises Refusal."""
    text = scalar.text
    if not scalar.plain:
        if _FLOAT.fullmatch(text):
            raise Refusal(f"not the text {shown(text)}; take the quotes away")
        raise Refusal(f"not the text {shown(text)}")
    if len(text) > _LONGEST_NUMBER:
        raise Refusal(f"not {shown(text)}")
    if _LEADING_ZERO.fullmatch(text) and text.strip("+-0"):
        raise Refusal(f"not {shown(text)}: with a leading zero YAML readers disagree whether it is octal")
    if _DECIMAL.fullmatch(text) and len(text) <= _LONGEST_INTEGER:
        return int(text)
    if _HEX.fullmatch(text) or _OCTAL.fullmatch(text):
        if len(text) > _LONGEST_INTEGER:
            raise Refusal(f"not {shown(text)}, which is too large for a number")
        return int(text, 0)
    if _FLOAT.fullmatch(text):
        value = float(text)
        if math.isinf(value):
            raise Refusal(f"not {shown(text)}, which is too large for a number")
        return value
    raise Refusal(f"not {shown(text)}{_why_no_number(text)}")


def _why_no_number(text: str) -> str:
    """What is the matter with a text that looks like a number to some."""
    if _NOT_FINITE.fullmatch(text):
        return "; it must be finite"
    if _BASE_60.fullmatch(text):
        return ": some YAML readers take this for base 60; write one number"
    if _UNDERSCORES.fullmatch(text):
        return f"; write {text.replace('_', '')}"
    if comma := _COMMA.fullmatch(text):
        return f"; write {comma[1]}.{comma[2]} with a point"
    return ""


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
