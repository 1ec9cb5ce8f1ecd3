"""The kinds of setting that a preset has: what each takes, within which limits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from ..common.registry import Registry

LARGEST = 1e9
"""Greatest magnitude of any number: squares and cubes of it still fit the single precision of the kernels."""
SMALLEST = 1e-9
"""Least positive number where zero is excluded; its square is still a normal number in single precision."""


MOST_ITEMS = 100_000
"""Entries of a list at the most, where nothing less is said."""
MOST_PANELS = 100
"""Panels of a preset at the most: each is a scene of its own."""
NO_COLOUR = "none"
"""What stands for no colour at all where there may be none; ``null`` stands for the default."""


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


class NumberSpec(Spec):
    """A finite number, which is a float."""

    type_name, words = "number", "a number"


class IntegerSpec(Spec):
    """A whole number."""

    type_name, words = "integer", "a whole number"


class VectorSpec(Spec):
    """Three finite numbers, limits holding for each. ``nonzero`` refuses (0, 0, 0)."""

    type_name = "[x, y, z]"

    def __init__(self, default: Any = None, *, nonzero: bool = False, **more: Any) -> None:
        super().__init__(default, **more)
        self.nonzero = nonzero

    def wanted(self) -> str:
        each = f" each {self.limits}" if str(self.limits) else ""
        return f"three numbers [x, y, z]{each}{in_unit(self.unit)}"


class ColourSpec(Spec):
    """A linear Rec. 709 colour: three numbers that are not negative, or "#rrggbb" in sRGB; with ``or_none`` also the
    word `NO_COLOUR`."""

    type_name = "colour"

    def __init__(self, default: Any = None, *, doc: str = "", or_none: bool = False) -> None:
        super().__init__(default, doc=doc)
        self.or_none = or_none

    def wanted(self) -> str:
        none = f", or {NO_COLOUR}" if self.or_none else ""
        return f'three linear numbers [r, g, b] or "#rrggbb" in quotes{none}'


class SizeSpec(Spec):
    """Width and height in whole pixels from 1 to ``high``, as [w, h] or "800x600"."""

    type_name = '[w, h] or "800x600"'

    def __init__(self, default: tuple[int, int], *, high: int, doc: str = "") -> None:
        super().__init__(default, doc=doc, unit="px", low=1, high=high)

    def wanted(self) -> str:
        return f'a size [w, h] or "800x600" of at least 1 and at most {self.limits.high}{in_unit(self.unit)}'


class WindowSpec(Spec):
    """Part of a picture as (x, y, width, height) in whole pixels from the upper left, as [x, y, w, h] or
    "400x300+100+50"; by default None."""

    type_name = '[x, y, w, h] or "400x300+100+50"'

    def __init__(self, *, high: int, doc: str = "") -> None:
        super().__init__(doc=doc, unit="px", low=0, high=high)

    def wanted(self) -> str:
        return f'a part of the picture [x, y, width, height] or "400x300+100+50"{in_unit(self.unit)}'


class ChoiceSpec(Spec):
    """One of a few words, or of the names in a registry, which may grow. ``removed``: what a message says of words that
    are none any more."""

    def __init__(
        self, default: str, options: tuple[str, ...] | Registry, *, doc: str = "",
        removed: Mapping[str, str] | None = None,
    ) -> None:  # fmt: skip
        super().__init__(default, doc=doc)
        self._options = options
        self.removed = removed or {}

    @property
    def options(self) -> tuple[str, ...]:
        """The words, in order."""
        return self._options if isinstance(self._options, tuple) else self._options.names()

    def wanted(self) -> str:
        return self.options[0] if len(self.options) == 1 else f"one of {', '.join(self.options)}"


class BooleanSpec(Spec):
    """true or false."""

    type_name, words = "boolean", "true or false"


class TextSpec(Spec):
    """Any text."""

    type_name, words = "text", "text"


class FileSpec(TextSpec):
    """The path of a file that is there, beside the preset that names it, or of ``numbered`` ones; ``kind``: who reads
    it, as `strandcli.run.fingerprint.READERS` has it. It has to be given, or with a default of None may be absent."""

    type_name, words = "file", "the path of a file"

    def __init__(self, kind: str, default: str | None = "", *, doc: str = "", numbered: bool = False) -> None:
        super().__init__(default, doc=doc)
        self.kind, self.numbered = kind, numbered


class MapSpec(TextSpec):
    """The name of an attribute of a mesh's vertices, or the path of a picture, which has a suffix; by default
    neither."""

    type_name, words = "name or picture", "the name of an attribute, or the path of a picture"
    kind = "picture"

    def __init__(self, *, doc: str = "") -> None:
        super().__init__("", doc=doc)


class NamesSpec(Spec):
    """A tuple of names; one name may stand without the list."""

    type_name, words = "list of names", "a name or a list of names"

    def __init__(self, default: tuple[str, ...] = (), *, doc: str = "") -> None:
        super().__init__(default, doc=doc)


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
    """A list of mappings, ``most`` at the most: ``of`` one class, which ``kinds`` then has under the key "", or each of
    the class that its ``kind`` names. Kinds that are added later count as well."""

    type_name, words = "list", "a list, each entry beginning with `- `"

    def __init__(
        self, of: type | Mapping[str, type], *, default: tuple[Any, ...] = (), most: int = MOST_ITEMS, doc: str = ""
    ) -> None:
        super().__init__(default, doc=doc)
        self.kinds: Mapping[str, type] = {"": of} if isinstance(of, type) else of
        self.most = most

    @property
    def tagged(self) -> bool:
        """Whether an item must name its ``kind``."""
        return "" not in self.kinds


class ParametersSpec(Spec):
    """A mapping with the settings of the driver that a sibling setting, ``chooser``, names; None where it has none of
    its own."""

    def __init__(self, registry: Registry, chooser: str, *, doc: str = "") -> None:
        super().__init__(doc=doc)
        self.registry = registry
        self.chooser = chooser


class RulesSpec(Spec):
    """The rules: a list in the order of application, or a mapping in the default order."""

    type_name, words = "list or mapping", "a list or a mapping of rules"


class PanelsSpec(Spec):
    """A list of variants of the scene."""

    type_name, words = "list", "a list, each entry beginning with `- `"
