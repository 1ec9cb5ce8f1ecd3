"""The kinds of setting that a preset has, and the helpers that declare them beside the fields of a dataclass.

``strands: int = integer(10_000, low=1, doc="number of strands")`` declares a dataclass field with a default, and tells
the validator, the JSON Schema and the documentation the rest. Rules declare their parameters with the same helpers.

Ranges: ``low`` and ``high`` may be reached, ``above`` and ``below`` may not. A trailing underscore in a field's name is
not part of its key (``with_`` is written ``with``).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import Any, NamedTuple

Vector = tuple[float, float, float]
Colour = tuple[float, float, float]

LARGEST = 1e9
"""Greatest magnitude of any number: squares and cubes of it still fit the single precision of the kernels."""
SMALLEST = 1e-9
"""Least positive number where zero is excluded; its square is still a normal number in single precision."""


class Range:
    """What a number may be; None is no limit."""

    __slots__ = ("above", "below", "high", "low")

    def __init__(
        self,
        *,
        low: float | None = None,
        above: float | None = None,
        below: float | None = None,
        high: float | None = None,
    ) -> None:
        self.low = low
        self.above = above
        self.below = below
        self.high = high

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

    def __str__(self) -> str:
        parts = (("of at least", self.low), ("above", self.above), ("below", self.below), ("of at most", self.high))
        # a limit that is no whole number in Python's eyes is written as a person would: 1e+13
        return " and ".join(
            f"{word} {limit:.12g}" if isinstance(limit, float) else f"{word} {limit}"
            for word, limit in parts
            if limit is not None
        )


ANY = Range()
"""No limits but those of single precision."""


class Spec:
    """What every setting has: its value where none is written, what it means, and in which unit.

    Specs are plain classes: made at every start, dataclasses of them would take 20 ms.
    """

    def __init__(self, default: Any = None, *, doc: str = "", unit: str = "", limits: Range = ANY) -> None:
        self.default = default
        self.doc = doc
        self.unit = unit
        self.limits = limits


class NumberSpec(Spec):
    """A finite number within ``limits``."""


class IntegerSpec(Spec):
    """A whole number within ``limits``."""


class VectorSpec(Spec):
    """Three finite numbers, ``limits`` holding for each. ``nonzero`` refuses (0, 0, 0)."""

    def __init__(
        self, default: Any = None, *, doc: str = "", unit: str = "", limits: Range = ANY, nonzero: bool = False
    ) -> None:
        super().__init__(default, doc=doc, unit=unit, limits=limits)
        self.nonzero = nonzero


class ColourSpec(Spec):
    """Three linear numbers that are not negative, or "#rrggbb" in sRGB."""


class SizeSpec(Spec):
    """Two whole numbers within ``limits``, as [w, h] or "800x600"."""


class WindowSpec(Spec):
    """Part of a picture as (x, y, width, height) in whole pixels from the upper left, as [x, y, w, h] or
    "400x300+100+50"."""


class ChoiceSpec(Spec):
    """One of a few words."""

    def __init__(self, default: str, options: tuple[str, ...], *, doc: str = "") -> None:
        super().__init__(default, doc=doc)
        self.options = options


class BooleanSpec(Spec):
    """true or false."""


class TextSpec(Spec):
    """Any text."""


class FileSpec(TextSpec):
    """The path of a file that is there, beside the preset that names it."""


class NamesSpec(Spec):
    """A list of names; one name may stand without the list."""


class ModelSpec(Spec):
    """A mapping with the settings of one class. A default of None makes it one that may be absent."""

    def __init__(self, model: type, default: Any = None, *, doc: str = "") -> None:
        super().__init__(default, doc=doc)
        self.model = model


class UnionSpec(Spec):
    """A mapping with the settings of one of several classes, told by its ``kind``; without one, the default's."""

    def __init__(self, default: Any, kinds: Mapping[str, type], *, doc: str = "") -> None:
        super().__init__(default, doc=doc)
        self.kinds = kinds


class ItemsSpec(Spec):
    """A list of mappings, of one class (under the key "" of ``kinds``) or each of the class that its ``kind`` names."""

    def __init__(self, default: tuple[Any, ...], kinds: Mapping[str, type], *, doc: str = "") -> None:
        super().__init__(default, doc=doc)
        self.kinds = kinds

    @property
    def tagged(self) -> bool:
        """Whether an item must name its ``kind``."""
        return "" not in self.kinds


class RulesSpec(Spec):
    """The rules: a list in the order of application, or a mapping in the default order."""


class PanelsSpec(Spec):
    """A list of variants of the scene."""


def _field(spec: Spec) -> Any:
    return dataclasses.field(default=spec.default, metadata={"spec": spec})


def number(
    default: float | None,
    *,
    low: float | None = None,
    above: float | None = None,
    below: float | None = None,
    high: float | None = None,
    unit: str = "",
    doc: str = "",
) -> Any:
    """A field that is a finite float."""
    limits = Range(low=low, above=above, below=below, high=high)
    return _field(NumberSpec(default, limits=limits, unit=unit, doc=doc))


def integer(
    default: int | None, *, low: int | None = None, high: int | None = None, unit: str = "", doc: str = ""
) -> Any:
    """A field that is an int."""
    return _field(IntegerSpec(default, limits=Range(low=low, high=high), unit=unit, doc=doc))


def vector(
    default: Vector | None,
    *,
    low: float | None = None,
    above: float | None = None,
    below: float | None = None,
    high: float | None = None,
    nonzero: bool = False,
    unit: str = "",
    doc: str = "",
) -> Any:
    """A field that is three finite floats; the range holds for each of them."""
    limits = Range(low=low, above=above, below=below, high=high)
    return _field(VectorSpec(default, limits=limits, nonzero=nonzero, unit=unit, doc=doc))


def colour(default: Colour | None, *, doc: str = "") -> Any:
    """A field that is a linear Rec. 709 colour."""
    return _field(ColourSpec(default, doc=doc))


def size(default: tuple[int, int], *, high: int, unit: str = "px", doc: str = "") -> Any:
    """A field that is a width and a height."""
    return _field(SizeSpec(default, limits=Range(low=1, high=high), unit=unit, doc=doc))


def window(*, high: int, unit: str = "px", doc: str = "") -> Any:
    """A field that is part of a picture, or None, which is its default."""
    return _field(WindowSpec(None, limits=Range(low=0, high=high), unit=unit, doc=doc))


def choice(default: str, options: tuple[str, ...], *, doc: str = "") -> Any:
    """A field that is one of a few words."""
    return _field(ChoiceSpec(default, options, doc=doc))


def boolean(default: bool, *, doc: str = "") -> Any:
    """A field that is true or false."""
    return _field(BooleanSpec(default, doc=doc))


def text(default: str, *, doc: str = "") -> Any:
    """A field that is text."""
    return _field(TextSpec(default, doc=doc))


def file(*, doc: str = "") -> Any:
    """A field that is the path of a file; it has to be given."""
    return _field(FileSpec("", doc=doc))


def names(default: tuple[str, ...] = (), *, doc: str = "") -> Any:
    """A field that is a tuple of names."""
    return _field(NamesSpec(default, doc=doc))


def model(cls: type, *, doc: str = "") -> Any:
    """A field that is an instance of ``cls``, by default with all its defaults."""
    return _field(ModelSpec(cls, cls(), doc=doc))


def optional(cls: type, *, doc: str = "") -> Any:
    """A field that is an instance of ``cls`` or None, which is its default."""
    return _field(ModelSpec(cls, doc=doc))


def union(default: Any, kinds: Mapping[str, type], *, doc: str = "") -> Any:
    """A field that is an instance of one of several classes, each with its own ``kind``."""
    return _field(UnionSpec(default, MappingProxyType(dict(kinds)), doc=doc))


def items(of: type | Mapping[str, type], *, default: tuple[Any, ...] = (), doc: str = "") -> Any:
    """A field that is a tuple of instances of a class, or of classes told apart by ``kind``."""
    kinds = {"": of} if isinstance(of, type) else dict(of)
    return _field(ItemsSpec(default, MappingProxyType(kinds), doc=doc))


def rules(*, doc: str = "") -> Any:
    """The field that holds a scene's rules."""
    return _field(RulesSpec((), doc=doc))


def panels(*, doc: str = "") -> Any:
    """The field that holds a scene's variants."""
    return _field(PanelsSpec((), doc=doc))


class Setting(NamedTuple):
    """One setting of a class: the key in YAML, the attribute in Python, and what it may be."""

    key: str
    attribute: str
    spec: Spec


@cache
def settings_of(cls: type) -> Mapping[str, Setting]:
    """The settings of a dataclass by key, in order. Fields made without these helpers are not settings."""
    found = (
        Setting(field.name.removesuffix("_"), field.name, field.metadata["spec"])
        for field in dataclasses.fields(cls)
        if "spec" in field.metadata
    )
    return MappingProxyType({setting.key: setting for setting in found})


def why_absent(cls: type, key: str) -> str | None:
    """Why a class has no setting of a name that people look for, where it says so in ``ABSENT``."""
    reasons: Mapping[str, str] = getattr(cls, "ABSENT", {})
    return reasons.get(key)
