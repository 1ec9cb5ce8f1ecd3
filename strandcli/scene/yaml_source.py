"""YAML text to a tree that knows its places (`nodes.py`).

Built on the events of PyYAML's parsers, whose state machines do not recurse, so that depth is checked before anything
grows. Refused: anchors and aliases (a few lines of them can unfold to gigabytes), tags,
duplicate keys (YAML lets the last one win in silence), more than one document, and anything that is not UTF-8.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NoReturn

from .faults import Fault, Mark, SceneError, fault_at, one_line, shown
from .nodes import Entry, ListNode, MapNode, Node, Scalar

if TYPE_CHECKING:
    import yaml

LARGEST_FILE = 1 << 20  # bytes
DEEPEST = 32


def read(data: bytes, file: str) -> tuple[MapNode, list[Fault]]:
    """The tree of a preset's bytes, and the faults after which reading could go on (duplicate keys, anchors, tags).

    Raises SceneError where there is no tree: not YAML, not UTF-8, too large or deep, empty, not a mapping.
    """
    if len(data) > LARGEST_FILE:
        raise SceneError([fault_at(Mark(file, 1, 1), "", f"is larger than {LARGEST_FILE} bytes; is it a preset?")])
    text = _decoded(data, file)
    builder = _Builder(Mark(file))
    root = builder.build(text)
    if root is None or (isinstance(root, Scalar) and root.empty):
        builder.stop(Mark(file, 1, 1), "is empty; a preset is a mapping such as `title: hair`")
    if not isinstance(root, MapNode):
        builder.stop(root.mark, "must be a mapping of settings, such as `title: hair`")
    return root, builder.faults


def read_value(text: str, file: str) -> Node:
    """The tree of a value given on the command line; ``file`` names it in messages, and marks have no lines.

    Only single values and flow collections (``[1, 2]``, ``{a: 1}``) are YAML here. Anything that would be a block
    mapping or a comment (``Wind: strong``, ``#ff0000``) is taken as text.

    Raises SceneError.
    """
    here = Mark(file)
    builder = _Builder(here, lines=False)
    comment = text.lstrip().startswith("#")
    node = Scalar(builder.checked(text.strip(), here), True, here) if comment else builder.build(text)
    if builder.faults:
        raise SceneError(builder.faults)
    if node is None:
        return Scalar("", True, here)
    if not isinstance(node, Scalar) and not text.lstrip().startswith(("[", "{")):
        return Scalar(text.strip(), True, here)  # it was a block mapping or list, of which `--set` has none
    return node


class _Builder:
    """Builds one tree from events, and gathers faults on the way."""

    def __init__(self, origin: Mark, lines: bool = True) -> None:
        self.origin = origin
        self.lines = lines
        self.faults: list[Fault] = []

    def stop(self, mark: Mark, message: str) -> NoReturn:
        """Give up, reporting what was found so far too."""
        raise SceneError([*self.faults, fault_at(mark, "", message)])

    def mark(self, mark: Any) -> Mark:
        """PyYAML's mark as ours."""
        if mark is None or not self.lines:
            return self.origin
        return Mark(self.origin.file, mark.line + 1, mark.column + 1)

    def build(self, text: str) -> Node | None:
        """The tree of ``text``, or None where it holds no document. By libyaml, 100 times faster; but what is wrong is
        explained best by the parser in Python."""
        import yaml  # 30 ms, which commands that read no preset need not spend

        if yaml.__with_libyaml__:
            try:
                return self.root(yaml.parse(text, Loader=yaml.CSafeLoader))
            except (yaml.YAMLError, ValueError, OverflowError):
                self.faults = []
        try:
            return self.root(yaml.parse(text, Loader=yaml.SafeLoader))
        except yaml.reader.ReaderError as error:
            line = text.count("\n", 0, error.position)
            column = error.position - (text.rfind("\n", 0, error.position) + 1)
            mark = Mark(self.origin.file, line + 1, column + 1) if self.lines else self.origin
            self.stop(mark, f"has a character that YAML does not allow: {shown(text[error.position])}")
        except yaml.MarkedYAMLError as error:
            self.stop(self.mark(error.problem_mark or error.context_mark), _advice(error))
        except (ValueError, OverflowError):  # PyYAML on \UFFFFFFFF, and on a %YAML directive of 5,000 digits
            mark = self.origin if not self.lines else Mark(self.origin.file, 1, 1)
            self.stop(mark, "has a number or an escape that YAML does not allow")

    def root(self, events: Iterator[yaml.Event]) -> Node | None:
        """The tree of the only document."""
        import yaml

        root: Node | None = None
        for event in events:
            if isinstance(event, yaml.DocumentStartEvent) and root is not None:
                self.stop(
                    self.mark(event.start_mark), "has more than one document; a preset is one, without `---` inside"
                )
            if isinstance(event, yaml.NodeEvent):
                root = self.node(event, events, 0)
        return root

    def node(self, event: yaml.Event, events: Iterator[yaml.Event], depth: int) -> Node:
        """The tree that an event begins, so deep inside its parents."""
        import yaml

        mark = self.mark(event.start_mark)
        if isinstance(event, yaml.AliasEvent):
            self.refuse(mark, f"`*{event.anchor}`: aliases are refused; write the value again, or use `extends`")
            return Scalar("null", True, mark)
        assert isinstance(event, yaml.ScalarEvent | yaml.CollectionStartEvent)
        if event.anchor is not None:
            self.refuse(mark, f"`&{event.anchor}`: anchors are refused; write the value again, or use `extends`")
        if event.tag is not None:
            self.refuse(mark, f"`{event.tag}`: tags are refused")
        if isinstance(event, yaml.ScalarEvent):
            return Scalar(self.checked(event.value, mark), not event.style, mark)
        if depth >= DEEPEST:
            self.stop(mark, f"is nested more than {DEEPEST} deep")
        inside: list[Node] = []
        entries: dict[str, Entry] = {}
        while not isinstance(one := next(events), yaml.CollectionEndEvent):
            node = self.node(one, events, depth + 1)
            if isinstance(event, yaml.SequenceStartEvent):
                inside.append(node)
                continue
            key = self.key(entries, node)
            value = self.node(next(events), events, depth + 1)
            if key is not None:
                entries[key] = Entry(node.mark, value)
        return ListNode(tuple(inside), mark) if isinstance(event, yaml.SequenceStartEvent) else MapNode(entries, mark)

    def key(self, entries: Mapping[str, Entry], node: Node) -> str | None:
        """The key that ``node`` is, or None after a fault."""
        if not isinstance(node, Scalar):
            self.refuse(node.mark, "a key must be a single word")
            return None
        if node.text == "<<" and node.plain:
            self.refuse(node.mark, "merge keys are refused; use `extends`")
            return None
        if node.text in entries:
            first = entries[node.text].mark.line
            where = f", first given on line {first}" if first else ""
            self.refuse(node.mark, f"duplicate key {shown(node.text)}{where}")
            return None
        return node.text

    def checked(self, text: str, mark: Mark) -> str:
        """``text``, of which escapes may have made something that cannot be printed or encoded."""
        if any(_unwanted(c) for c in text):
            self.refuse(mark, f"has a control character or half a surrogate pair: {shown(text)}")
            return "".join(" " if _unwanted(c) else c for c in text)
        return text

    def refuse(self, mark: Mark, message: str) -> None:
        """Note a fault and go on."""
        self.faults.append(fault_at(mark, "", message))


def _unwanted(character: str) -> bool:
    return (character < " " and character not in "\t\n") or character == "\x7f" or "\ud800" <= character <= "\udfff"


def _decoded(data: bytes, file: str) -> str:
    if data.startswith((b"\xff\xfe", b"\xfe\xff")) or b"\0" in data[:2]:
        raise SceneError([fault_at(Mark(file, 1, 1), "", "is UTF-16 text; save it as UTF-8")])
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        column = len(data[data.rfind(b"\n", 0, error.start) + 1 : error.start].decode("utf-8", "replace")) + 1
        message = f"is not UTF-8 text (byte 0x{data[error.start]:02x}); if it is a preset, save it as UTF-8"
        raise SceneError([fault_at(Mark(file, line, column), "", message)]) from None


def _advice(error: yaml.MarkedYAMLError) -> str:
    """PyYAML's complaint in words that tell what to do."""
    problem = one_line(error.problem or error.context or "unreadable")
    if "'\\t'" in problem or "'\\\\t'" in problem:
        return "not valid YAML: a tab cannot indent; use spaces"
    if "mapping values are not allowed" in problem:
        return "not valid YAML: a `: ` where no mapping can begin; check the indentation, or quote the text"
    if "cannot start any token" in problem:
        return f"not valid YAML: {problem}; quote the text"
    return f"not valid YAML: {problem}"
