"""Single values: numbers and what is made of several, words, truth values, texts, names and files."""

from __future__ import annotations

import math
import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...common.registry import Registry
from ...files import numbered as numbered_files
from ...files.inputs import note
from ..faults import hint, one_line, shown
from ..nodes import ListNode, Node, Scalar, given
from .base import SMALLEST, WORD, Json, Range, Refusal, Spec, in_unit

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


LONGEST_PATH = 240
"""Characters of a path that messages show, from its end."""
_TRUE = ("true", "True", "TRUE")
_FALSE = ("false", "False", "FALSE")
_YES = ("yes", "on", "y")
_NO = ("no", "off", "n")


class ChoiceSpec(Spec):
    """One of a few words, or of the names in a registry, which may grow."""

    def __init__(self, default: str, options: tuple[str, ...] | Registry, *, doc: str = "") -> None:
        super().__init__(default, doc=doc)
        self._options = options

    @property
    def options(self) -> tuple[str, ...]:
        """The words, in order."""
        return self._options if isinstance(self._options, tuple) else self._options.names()

    def wanted(self) -> str:
        return self.options[0] if len(self.options) == 1 else f"one of {', '.join(self.options)}"

    def scalar(self, node: Scalar) -> str:
        if node.text in self.options:
            return node.text
        guess = hint(node.text, self.options, "") if len(self.options) > 1 else ""
        raise Refusal(f"not {shown(node.text)}; {guess}" if guess.startswith("did") else f"not {shown(node.text)}")

    def schema(self, writer: Writer) -> Json:
        return {"enum": list(self.options)}


class BooleanSpec(Spec):
    """true or false."""

    type_name, words = "boolean", "true or false"

    def scalar(self, node: Scalar) -> bool:
        if node.plain and node.text in _TRUE:
            return True
        if node.plain and node.text in _FALSE:
            return False
        word = node.text.lower()
        if node.plain and (word in _YES or word in _NO):
            meant = "true" if word in _YES else "false"
            raise Refusal(f"not {shown(node.text)}, which YAML readers disagree about; write {meant}")
        raise Refusal(f"not {shown(node.text)}")

    def schema(self, writer: Writer) -> Json:
        return {"type": "boolean"}


class TextSpec(Spec):
    """Any text."""

    type_name, words = "text", "text"

    def scalar(self, node: Scalar) -> str:
        return node.text


class FileSpec(TextSpec):
    """The path of a file that is there, beside the preset that names it, or of ``numbered`` ones; ``kind``: who reads
    it, as `strandcli.run.fingerprint.READERS` has it. It has to be given, or with a default of None may be absent."""

    type_name, words = "file", "the path of a file"

    def __init__(self, kind: str, default: str | None = "", *, doc: str = "", numbered: bool = False) -> None:
        super().__init__(default, doc=doc)
        self.kind, self.numbered = kind, numbered

    def scalar(self, node: Scalar) -> str:
        """The path as it is from here: one in a preset is meant from the preset's folder."""
        path = Path(node.text)
        if node.mark.line > 0:
            path = Path(node.mark.file).parent / path
        if not os.path.isfile(path):  # Path.is_file raises where a name is too long
            if self.numbered and numbered_files.is_numbered(path) and numbered_files.numbered(path):
                return str(path.absolute())
            note(path)  # whoever watches the preset's files looks for it
            shown_path = one_line(str(path)[-LONGEST_PATH:])
            if os.path.exists(path):
                kind = "a folder" if os.path.isdir(path) else "no file but a device or a pipe"
                raise Refusal(f"and {shown_path} is {kind}")
            raise Refusal(f"and there is no file {shown_path}")
        return str(path.absolute())  # so that it stays the same file wherever the scene is dumped to


class MapSpec(FileSpec):
    """The name of an attribute of a mesh's vertices, or the path of a picture, which has a suffix; by default
    neither."""

    type_name, words = "name or picture", "the name of an attribute, or the path of a picture"

    def __init__(self, *, doc: str = "") -> None:
        super().__init__("picture", doc=doc)

    def scalar(self, node: Scalar) -> str:
        return super().scalar(node) if Path(node.text).suffix else node.text


class NamesSpec(Spec):
    """A tuple of names; one name may stand without the list."""

    type_name, words = "list of names", "a name or a list of names"

    def __init__(self, default: tuple[str, ...] = (), *, doc: str = "") -> None:
        super().__init__(default, doc=doc)

    def read(self, reader: Reader, node: Node, path: str) -> tuple[str, ...]:
        found = []
        for index, item in enumerate(node.items if isinstance(node, ListNode) else (node,)):
            if not isinstance(item, Scalar) or item.empty or item.null:
                raise Refusal(f"not {given(item)}")
            reader.marks[f"{path}.{index}"] = item.mark
            found.append(item.text)
        return tuple(found)

    def schema(self, writer: Writer) -> Json:
        return {"anyOf": [WORD, {"type": "array", "items": WORD}]}
