"""Single values that are checked against their setting: ranges, whole numbers, words, files, parts of a picture."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from ..files import numbered as numbered_files
from ..files.inputs import note
from .faults import hint, one_line, shown
from .nodes import ListNode, MapNode, Node, Scalar, kind_of
from .scalars import Refusal, as_number, as_window
from .specs import ChoiceSpec, Range, Spec, WindowSpec

LONGEST_PATH = 240
"""Characters of a path that messages show, from its end."""


def given(node: Node) -> str:
    """What stands there, for messages."""
    if isinstance(node, ListNode):
        if all(isinstance(item, Scalar) for item in node.items):
            return shown(f"[{', '.join(item.text for item in node.items if isinstance(item, Scalar))}]")
        return f"a list of {len(node.items)}"
    return shown(node.text) if isinstance(node, Scalar) and not node.empty else kind_of(node)


def no_rule(node: Node) -> str:
    """The message for an entry of the list of rules that is none."""
    if isinstance(node, MapNode) and len(node.entries) > 1:
        keys = list(node.entries)
        return (
            f"must be one rule, not {len(keys)} keys; if {shown(keys[1])} is a setting of {shown(keys[0])}, "
            "indent it further"
        )
    return f"must be a rule's name or `name: {{setting: value}}`, not {given(node)}"


def in_range(value: float, limits: Range, node: Scalar) -> float:
    if not limits.holds(value):
        beyond = "; single precision ends before that" if limits.spans(value) else ""
        raise Refusal(f"not {shown(node.text)}{beyond}")
    return value


def whole(node: Scalar, limits: Range) -> int:
    value = as_number(node)
    if isinstance(value, float) and not value.is_integer():
        raise Refusal(f"not {shown(node.text)}")
    in_range(value, limits, node)
    return int(value)


def pixels(spec: Spec, node: Node, count: int, read: Callable[[Scalar], tuple[int, ...]]) -> tuple[int, ...]:
    """So many whole numbers of pixels, from a list or by ``read`` from text."""
    if isinstance(node, Scalar) and not node.empty:
        found = read(node)
    elif isinstance(node, ListNode) and len(node.items) == count and all(isinstance(i, Scalar) for i in node.items):
        found = tuple(whole(item, spec.limits) for item in node.items if isinstance(item, Scalar))
    else:
        raise Refusal(f"not {given(node)}")
    if not all(spec.limits.holds(number) for number in found):
        raise Refusal(f"not {given(node)}")
    return found


def window(spec: WindowSpec, node: Node) -> tuple[int, ...]:
    """Left, top, width and height of a part of a picture that holds a pixel at least."""
    found = pixels(spec, node, 4, as_window)
    if 0 in found[2:]:
        raise Refusal(f"not {given(node)}")
    return found


def file_path(node: Scalar, numbered: bool = False) -> str:
    """A path as it is from here: one in a preset is meant from the preset's folder. ``numbered``: it may stand for
    files that are numbered."""
    path = Path(node.text)
    if node.mark.line > 0:
        path = Path(node.mark.file).parent / path
    if not os.path.isfile(path):  # Path.is_file raises where a name is too long
        if numbered and numbered_files.is_numbered(path) and numbered_files.numbered(path):
            return str(path.absolute())
        note(path)  # whoever watches the preset's files looks for it
        shown_path = one_line(str(path)[-LONGEST_PATH:])
        if os.path.exists(path):
            kind = "a folder" if os.path.isdir(path) else "no file but a device or a pipe"
            raise Refusal(f"and {shown_path} is {kind}")
        raise Refusal(f"and there is no file {shown_path}")
    return str(path.absolute())  # so that it stays the same file wherever the scene is dumped to


def name_or_file(node: Scalar) -> str:
    """A name, or as `file_path` what has a suffix."""
    return file_path(node) if Path(node.text).suffix else node.text


def option(node: Scalar, spec: ChoiceSpec) -> str:
    if node.text in spec.options:
        return node.text
    if node.text in spec.removed:
        raise Refusal(f"not {shown(node.text)}; {spec.removed[node.text]}")
    guess = hint(node.text, spec.options, "") if len(spec.options) > 1 else ""
    raise Refusal(f"not {shown(node.text)}; {guess}" if guess.startswith("did") else f"not {shown(node.text)}")
