"""The tree that a YAML file is read into: text, lists and mappings, each knowing where it was written.

A scalar keeps its text and is given a type only where the setting that it fills says which (`specs`). This is what
keeps YAML's guesses out: `no` is never False before somebody asks for a truth value.

Trees are never changed in place; what changes them gives a new tree that shares the rest with the old one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from .faults import Mark, shown

NULLS = ("null", "Null", "NULL", "~")


class Scalar:
    """A single value. ``plain`` tells that it was written without quotes."""

    __slots__ = ("mark", "plain", "text")

    def __init__(self, text: str, plain: bool, mark: Mark) -> None:
        self.text = text
        self.plain = plain
        self.mark = mark

    @property
    def empty(self) -> bool:
        """Nothing was written at all, as after ``strands:``."""
        return self.plain and not self.text

    @property
    def null(self) -> bool:
        """An explicit ``null`` or ``~``."""
        return self.plain and self.text in NULLS


class ListNode:
    """A list."""

    __slots__ = ("items", "mark")

    def __init__(self, items: tuple[Node, ...], mark: Mark) -> None:
        self.items = items
        self.mark = mark


class Entry(NamedTuple):
    """One line of a mapping: where its key stands, and its value."""

    mark: Mark
    node: Node


class MapNode:
    """A mapping, in the order in which it was written."""

    __slots__ = ("entries", "mark")

    def __init__(self, entries: Mapping[str, Entry], mark: Mark) -> None:
        self.entries = entries
        self.mark = mark

    def get(self, key: str) -> Node | None:
        """The value of ``key``, or None where it is not written."""
        entry = self.entries.get(key)
        return None if entry is None else entry.node

    def with_entry(self, key: str, entry: Entry) -> MapNode:
        """This mapping with one entry added or replaced."""
        return MapNode({**self.entries, key: entry}, self.mark)

    def without(self, *keys: str) -> MapNode:
        """This mapping with some keys taken out."""
        return MapNode({key: entry for key, entry in self.entries.items() if key not in keys}, self.mark)


Node = Scalar | ListNode | MapNode


def node_of(value: Any, mark: Mark) -> Node:
    """The tree of a Python value: None, bool, number, str, or a list, tuple or mapping of such.

    Raises TypeError for anything else.
    """
    if value is None:
        return Scalar("null", True, mark)
    if isinstance(value, bool):
        return Scalar("true" if value else "false", True, mark)
    if isinstance(value, int):
        # str() refuses ints above 4300 digits; no setting comes near that
        return Scalar(str(value) if abs(value) < 10**100 else "1e999", True, mark)
    if isinstance(value, float):
        return Scalar(repr(value) if math.isfinite(value) else f".{value}".replace(".-", "-."), True, mark)
    if isinstance(value, str):
        return Scalar(value, False, mark)
    if isinstance(value, Mapping):
        return MapNode({str(key): Entry(mark, node_of(item, mark)) for key, item in value.items()}, mark)
    if isinstance(value, Sequence):
        return ListNode(tuple(node_of(item, mark) for item in value), mark)
    raise TypeError(f"a setting cannot be a {type(value).__name__}")


def marks_of(node: Node) -> Iterator[Mark]:
    """All places in a tree."""
    yield node.mark
    if isinstance(node, ListNode):
        for item in node.items:
            yield from marks_of(item)
    elif isinstance(node, MapNode):
        for entry in node.entries.values():
            yield entry.mark
            yield from marks_of(entry.node)


def kind_of(node: Node) -> str:
    """What a node is, for messages."""
    if isinstance(node, MapNode):
        return "a mapping"
    if isinstance(node, ListNode):
        return "a list"
    if node.empty:
        return "nothing"
    return "null" if node.null else "a single value"


def given(node: Node) -> str:
    """What stands there, for messages."""
    if isinstance(node, ListNode):
        if all(isinstance(item, Scalar) for item in node.items):
            return shown(f"[{', '.join(item.text for item in node.items if isinstance(item, Scalar))}]")
        return f"a list of {len(node.items)}"
    return shown(node.text) if isinstance(node, Scalar) and not node.empty else kind_of(node)
