"""A tree (`nodes.py`) to the typed data of `model`, with every fault on the way.

A faulty value is noted and its default put in its place, so that one pass finds all faults. What a mapping gives as
``null`` counts as not given.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from . import specs
from .faults import Fault, Mark, fault_at, hint, shown
from .fields import settings_of
from .model import RuleUse
from .nodes import ListNode, MapNode, Node, Scalar, given
from .rule_type import RuleType
from .suggest import hint_inside, why_absent

MOST_HINTS = 200
"""Faults of one file after which no more suggestions are sought: each takes half a millisecond."""


class Reader:
    """Reads nodes by their specs. ``faults`` gathers what is wrong, ``marks`` where each path was written."""

    def __init__(self, rules: Mapping[str, RuleType]) -> None:
        self.rules = rules
        self.faults: list[Fault] = []
        self.marks: dict[str, Mark] = {}

    def refuse(self, mark: Mark, path: str, message: str) -> None:
        """Note a fault."""
        self.faults.append(fault_at(mark, path, message))

    def mark_near(self, path: str) -> Mark | None:
        """Where ``path`` was written, or the nearest thing around it that was."""
        while path:
            if path in self.marks:
                return self.marks[path]
            path = path.rpartition(".")[0]
        return self.marks.get("")

    def model(self, cls: type, node: Node, path: str) -> Any:
        """An instance of ``cls`` from a mapping; nothing at all counts as an empty one."""
        self.marks[path] = node.mark
        if isinstance(node, Scalar) and node.empty:
            node = MapNode({}, node.mark)
        if not isinstance(node, MapNode):
            self.refuse(node.mark, path, f"must be a mapping of settings, not {given(node)}")
            return cls()
        settings = settings_of(cls)
        values: dict[str, Any] = {}
        for key, entry in node.entries.items():
            where = f"{path}.{key}" if path else key
            setting = settings.get(key)
            if setting is None:
                self.refuse(entry.mark, where, why_absent(where) or self.unknown_key(key, settings, top=not path))
            elif isinstance(entry.node, Scalar) and entry.node.null:
                self.marks[where] = entry.node.mark
            elif not isinstance(setting.spec, specs.ParametersSpec):
                values[setting.attribute] = self.value(setting.spec, entry.node, where)
        for key, setting in settings.items():
            if isinstance(setting.spec, specs.ParametersSpec):
                chosen = values.get(setting.spec.chooser, settings[setting.spec.chooser].spec.default)
                found = self.parameters(setting.spec, chosen, node.get(key), f"{path}.{key}")
                if found is not None:
                    values[setting.attribute] = found
        return cls(**values)

    def parameters(self, spec: specs.ParametersSpec, chosen: str, node: Node | None, path: str) -> Any:
        """The settings of the driver that was chosen, its defaults where none are written; None where it has none."""
        cls = spec.registry.settings(chosen)
        if node is None or (isinstance(node, Scalar) and node.null):
            return None if cls is None else cls()
        if cls is None:
            self.refuse(node.mark, path, f"{chosen} has no settings of its own here; take this out")
            return None
        return self.model(cls, node, path)

    def unknown_key(self, key: str, settings: Mapping[str, Any], top: bool) -> str:
        """The message for a key that is none of ``settings``."""
        if top and key in self.rules:
            return f"unknown key; {shown(key)} is a rule and belongs under `rules`"
        if len(self.faults) > MOST_HINTS:
            return "unknown key"
        if not settings:
            return "unknown key; there are no settings here"
        guess = hint_inside(key, settings, self.rules) if top else hint(key, settings, "the keys are")
        return f"unknown key; {guess}"

    def value(self, spec: specs.Spec, node: Node, path: str) -> Any:
        """The value of one setting, or its default after a fault."""
        self.marks[path] = node.mark
        try:
            return spec.read(self, node, path)
        except specs.Refusal as refusal:
            absent = why_absent(path, node.text) if isinstance(node, Scalar) else None
            self.refuse(node.mark, path, absent or f"must be {spec.wanted()}, {refusal}")
            return spec.default

    def kind(self, kinds: Mapping[str, type], node: MapNode, path: str) -> type | None:
        """The class that a mapping's ``kind`` names, or None after a fault."""
        named = node.get("kind")
        if named is None:
            self.refuse(node.mark, path, f"has no kind; the kinds are {', '.join(kinds)}")
            return None
        if isinstance(named, Scalar) and named.text in kinds:
            return kinds[named.text]
        text = named.text if isinstance(named, Scalar) else ""
        known = shown(text) if text else given(named)
        self.refuse(named.mark, f"{path}.kind", f"unknown kind {known}; {hint(text, kinds, 'the kinds are')}")
        return None

    def rule_uses(self, node: Node, path: str) -> tuple[RuleUse, ...]:
        """The rules in the order in which they are to be applied."""
        entries: list[tuple[str, Mark, Node]] = []
        if isinstance(node, ListNode):
            for index, item in enumerate(node.items):
                if isinstance(item, Scalar) and not item.empty and not item.null:
                    entries.append((item.text, item.mark, MapNode({}, item.mark)))
                elif isinstance(item, MapNode) and len(item.entries) == 1:
                    entries.extend((name, entry.mark, entry.node) for name, entry in item.entries.items())
                else:
                    self.refuse(item.mark, f"{path}.{index}", _no_rule(item))
        elif isinstance(node, MapNode):
            for name, (mark, inner) in node.entries.items():
                if not (isinstance(inner, Scalar) and inner.null):
                    entries.append((name, mark, inner))
            entries.sort(key=lambda e: self.rules[e[0]].order if e[0] in self.rules else math.inf)
        elif not node.empty:
            raise specs.Refusal(f"not {given(node)}")
        uses, counts = [], dict.fromkeys(self.rules, 0)
        for name, mark, parameters in entries:
            if name not in self.rules:
                guess, known = hint(name, self.rules, "the rules are"), ", ".join(self.rules)
                more = f" The rules are {known}" if guess.startswith("did you mean") else ""
                self.refuse(mark, path, f"unknown rule {shown(name)}; {guess}{more}")
                continue
            counts[name] += 1
            where = name if counts[name] == 1 else f"{name}[{counts[name]}]"
            if isinstance(parameters, Scalar) and parameters.null:
                parameters = MapNode({}, parameters.mark)
            uses.append(RuleUse(name, self.model(self.rules[name].Parameters, parameters, where), where))
        return tuple(uses)


def _no_rule(node: Node) -> str:
    """The message for an entry of the list of rules that is none."""
    if isinstance(node, MapNode) and len(node.entries) > 1:
        first, second, *_ = node.entries
        inside = f"if {shown(second)} is a setting of {shown(first)}, indent it further"
        return f"must be one rule, not {len(node.entries)} keys; {inside}"
    return f"must be a rule's name or `name: {{setting: value}}`, not {given(node)}"
