"""Mappings of settings, one or of several kinds, and lists of such."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ...common.registry import Registry
from ..nodes import ListNode, MapNode, Node, given
from .base import Json, Refusal, Spec

if TYPE_CHECKING:
    from ..schema import Writer
    from ..validate import Reader

MOST_ITEMS = 100_000
"""Entries of a list at the most, where nothing less is said."""
MOST_PANELS = 100
"""Panels of a preset at the most: each is a scene of its own."""


class ModelSpec(Spec):
    """A mapping with the settings of one class. A default of None makes it one that may be absent."""

    def __init__(self, model: type, default: Any = None, *, doc: str = "") -> None:
        super().__init__(default, doc=doc)
        self.model = model

    def read(self, reader: Reader, node: Node, path: str) -> Any:
        return reader.model(self.model, node, path)

    def schema(self, writer: Writer) -> Json:
        return writer.reference(self.model)


class UnionSpec(Spec):
    """A mapping with the settings of one of several classes, chosen by its ``kind``; without one, the default's."""

    def __init__(self, default: Any, kinds: Mapping[str, type], *, doc: str = "") -> None:
        super().__init__(default, doc=doc)
        self.kinds = kinds

    def read(self, reader: Reader, node: Node, path: str) -> Any:
        if not isinstance(node, MapNode) or node.get("kind") is None:
            return reader.model(type(self.default), node, path)
        cls = reader.kind(self.kinds, node, path)
        return self.default if cls is None else reader.model(cls, node, path)

    def schema(self, writer: Writer) -> Json:
        return {"anyOf": [writer.kind(cls, cls is not type(self.default)) for cls in self.kinds.values()]}


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

    def read(self, reader: Reader, node: Node, path: str) -> Any:
        """A tuple of instances; what cannot be read is replaced by a stand-in, so that places stay right."""
        if not isinstance(node, ListNode):
            raise Refusal(f"not {given(node)}")
        if len(node.items) > self.most:
            reader.refuse(node.mark, path, f"may have {self.most:,} entries at the most, not {len(node.items):,}")
            return self.default
        found = []
        for index, item in enumerate(node.items):
            where = f"{path}.{index}"
            reader.marks[where] = item.mark
            stand_in = next(iter(self.kinds.values()))
            cls: type | None = stand_in
            if not isinstance(item, MapNode):
                reader.refuse(item.mark, where, f"must be a mapping of settings, not {given(item)}")
                cls = None
            elif self.tagged:
                cls = reader.kind(self.kinds, item, where)
            found.append(stand_in() if cls is None else reader.model(cls, item, where))
        return tuple(found)

    def schema(self, writer: Writer) -> Json:
        kinds = [writer.kind(cls, self.tagged) for cls in self.kinds.values()]
        return {"type": "array", "items": kinds[0] if len(kinds) == 1 else {"anyOf": kinds}, "maxItems": self.most}


class ParametersSpec(Spec):
    """A mapping with the settings of the driver that a sibling setting, ``chooser``, names; None where it has none of
    its own."""

    def __init__(self, registry: Registry, chooser: str, *, doc: str = "") -> None:
        super().__init__(doc=doc)
        self.registry = registry
        self.chooser = chooser

    def schema(self, writer: Writer) -> Json:
        own = [cls for name in self.registry.names() if (cls := self.registry.settings(name)) is not None]
        return {"anyOf": [writer.reference(cls) for cls in own] or [{"type": "object", "maxProperties": 0}]}


class RulesSpec(Spec):
    """The rules: a list in the order of application, or a mapping in the default order."""

    type_name, words = "list or mapping", "a list or a mapping of rules"

    def read(self, reader: Reader, node: Node, path: str) -> Any:
        return reader.rule_uses(node, path)

    def schema(self, writer: Writer) -> Json:
        return writer.rule_uses()


class PanelsSpec(Spec):
    """A list of variants of the scene."""

    type_name, words = "list", "a list, each entry beginning with `- `"

    def schema(self, writer: Writer) -> Json:
        return {"type": "array", "items": writer.panel(), "maxItems": MOST_PANELS}
