"""Numbers, and what is made of several: vectors, colours, sizes and parts of pictures."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any

from ..faults import shown
from ..nodes import ListNode, Node, Scalar, given
from .base import SMALLEST, Json, Range, Refusal, Spec, in_unit

if TYPE_CHECKING:
    from ..schema import Writer
    from ..validate import Reader

NO_COLOUR = "none"
"""What stands for no colour at all where there may be none; ``null`` stands for the default."""
SIZE = "[0-9]{1,9}\\s*[x×]\\s*[0-9]{1,9}"
_HEX_COLOUR = re.compile(r"#[0-9a-fA-F]{6}")


def array(count: int, each: Json) -> Json:
    """The JSON Schema of a list of so many entries."""
    return {"type": "array", "items": each, "minItems": count, "maxItems": count}


class NumberSpec(Spec):
    """A finite number, which is a float."""

    type_name, words = "number", "a number"

    def scalar(self, node: Scalar) -> float:
        return float(self.limits.number(node))

    def schema(self, writer: Writer) -> Json:
        return self.limits.schema("number")


class IntegerSpec(Spec):
    """A whole number."""

    type_name, words = "integer", "a whole number"

    def scalar(self, node: Scalar) -> int:
        return self.limits.whole(node)

    def schema(self, writer: Writer) -> Json:
        return self.limits.schema("integer")


class VectorSpec(Spec):
    """Three finite numbers, limits holding for each. ``nonzero`` refuses (0, 0, 0)."""

    type_name = "[x, y, z]"

    def __init__(self, default: Any = None, *, nonzero: bool = False, **more: Any) -> None:
        super().__init__(default, **more)
        self.nonzero = nonzero

    def wanted(self) -> str:
        each = f" each {self.limits}" if str(self.limits) else ""
        return f"three numbers [x, y, z]{each}{in_unit(self.unit)}"

    def read(self, reader: Reader, node: Node, path: str) -> Any:
        if not isinstance(node, ListNode) or len(node.items) != 3:
            raise Refusal(f"not {given(node)}")
        one = NumberSpec(unit=self.unit, **self.limits._asdict())
        found = [reader.value(one, item, f"{path}.{index}") for index, item in enumerate(node.items)]
        if None in found:
            return self.default
        if self.nonzero and math.hypot(*found) < SMALLEST:
            reader.refuse(node.mark, path, "must have a direction, not be zero")
            return self.default
        return tuple(found)

    def schema(self, writer: Writer) -> Json:
        vector = array(3, self.limits.schema("number"))
        return {**vector, "not": {"const": [0, 0, 0]}} if self.nonzero else vector


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

    def read(self, reader: Reader, node: Node, path: str) -> Any:
        if isinstance(node, ListNode) and len(node.items) == 3:
            return VectorSpec(self.default, low=0).read(reader, node, path)
        if isinstance(node, Scalar) and node.empty:
            raise Refusal("not nothing; without quotes a # begins a comment")
        return super().read(reader, node, path)

    def scalar(self, node: Scalar) -> Any:
        if self.or_none and node.text == NO_COLOUR:
            return NO_COLOUR
        if not _HEX_COLOUR.fullmatch(node.text):
            raise Refusal(f"not {shown(node.text)}")
        return tuple(linear(int(node.text[i : i + 2], 16) / 255.0) for i in (1, 3, 5))

    def schema(self, writer: Writer) -> Json:
        hexadecimal = {"type": "string", "pattern": "^#[0-9a-fA-F]{6}$"}
        none = [{"const": NO_COLOUR}] if self.or_none else []
        return {"anyOf": [array(3, Range(low=0).schema("number")), hexadecimal, *none]}


class SizeSpec(Spec):
    """Width and height in whole pixels from 1 to ``high``, as [w, h] or "800x600"."""

    type_name = '[w, h] or "800x600"'
    count, pattern = 2, SIZE

    def __init__(self, default: tuple[int, int], *, high: int, doc: str = "") -> None:
        super().__init__(default, doc=doc, unit="px", low=1, high=high)

    def wanted(self) -> str:
        return f'a size [w, h] or "800x600" of at least 1 and at most {self.limits.high}{in_unit(self.unit)}'

    def read(self, reader: Reader, node: Node, path: str) -> tuple[int, ...]:
        if isinstance(node, Scalar) and re.fullmatch(self.pattern, node.text):
            found = tuple(map(int, re.findall("[0-9]+", node.text)))
            found = (*found[2:], *found[:2])  # the size comes last
        elif isinstance(node, ListNode) and len(node.items) == self.count:
            found = tuple(self.limits.whole(item) for item in node.items)
        else:
            raise Refusal(f"not {given(node)}")
        if not all(self.limits.holds(number) for number in found) or 0 in found[-2:]:
            raise Refusal(f"not {given(node)}")
        return found

    def schema(self, writer: Writer) -> Json:
        numbers = array(self.count, self.limits.schema("integer"))
        return {"anyOf": [numbers, {"type": "string", "pattern": f"^{self.pattern}$"}]}


class WindowSpec(SizeSpec):
    """Part of a picture as (x, y, width, height) in whole pixels from the upper left, as [x, y, w, h] or
    "400x300+100+50"; by default None."""

    type_name = '[x, y, w, h] or "400x300+100+50"'
    count, pattern = 4, SIZE + "\\s*\\+\\s*[0-9]{1,9}\\s*\\+\\s*[0-9]{1,9}"

    def __init__(self, *, high: int, doc: str = "") -> None:
        Spec.__init__(self, doc=doc, unit="px", low=0, high=high)

    def wanted(self) -> str:
        return f'a part of the picture [x, y, width, height] or "400x300+100+50"{in_unit(self.unit)}'


def linear(encoded: float) -> float:
    """The linear value of an sRGB-encoded channel in 0 ... 1 (IEC 61966-2-1)."""
    if encoded <= 0.04045:
        return encoded / 12.92
    return math.pow((encoded + 0.055) / 1.055, 2.4)
