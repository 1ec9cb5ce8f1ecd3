"""The kinds of setting that a preset has: what each takes, within which limits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

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
    """Three linear numbers that are not negative, or "#rrggbb" in sRGB; with ``or_none`` also the word `NO_COLOUR`."""

    def __init__(self, default: Any = None, *, doc: str = "", or_none: bool = False) -> None:
        super().__init__(default, doc=doc)
        self.or_none = or_none


class SizeSpec(Spec):
    """Two whole numbers within ``limits``, as [w, h] or "800x600"."""


class WindowSpec(Spec):
    """Part of a picture as (x, y, width, height) in whole pixels from the upper left, as [x, y, w, h] or
    "400x300+100+50"."""


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


class BooleanSpec(Spec):
    """true or false."""


class TextSpec(Spec):
    """Any text."""


class FileSpec(TextSpec):
    """The path of a file that is there, beside the preset that names it, or of ``numbered`` ones; ``kind``: who reads
    it, as `strandcli.run.fingerprint.READERS` has it."""

    def __init__(self, default: Any = None, *, kind: str, doc: str = "", numbered: bool = False) -> None:
        super().__init__(default, doc=doc)
        self.kind, self.numbered = kind, numbered


class MapSpec(TextSpec):
    """The name of an attribute of a mesh's vertices, or the path of a picture, which has a suffix."""

    kind = "picture"


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

    def __init__(
        self, default: tuple[Any, ...], kinds: Mapping[str, type], *, most: int = MOST_ITEMS, doc: str = ""
    ) -> None:
        super().__init__(default, doc=doc)
        self.kinds = kinds
        self.most = most

    @property
    def tagged(self) -> bool:
        """Whether an item must name its ``kind``."""
        return "" not in self.kinds


class ParametersSpec(Spec):
    """A mapping with the settings of the driver that a sibling setting, ``chooser``, names; None where it has none of
    its own."""

    def __init__(self, registry: Registry, chooser: str, *, doc: str = "") -> None:
        super().__init__(None, doc=doc)
        self.registry = registry
        self.chooser = chooser


class RulesSpec(Spec):
    """The rules: a list in the order of application, or a mapping in the default order."""


class PanelsSpec(Spec):
    """A list of variants of the scene."""
