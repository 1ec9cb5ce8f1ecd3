"""Words, truth values, texts, names and files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from ...common.registry import Registry
from ...files import numbered as numbered_files
from ...files.inputs import note
from ..faults import hint, one_line, shown
from ..nodes import ListNode, Node, Scalar, given
from .base import WORD, Json, Refusal, Spec

if TYPE_CHECKING:
    from ..schema import Writer
    from ..validate import Reader

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
