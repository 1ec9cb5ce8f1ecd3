"""Changing a preset before it is validated: one tree laid over another, and single settings put at a dotted path.

`merge` serves ``extends``: mappings are merged deeply, anything else is replaced. `place` serves ``--set``, the
settings given from Python, and panels.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from . import specs
from .dump import plain
from .faults import hint, shown
from .fields import settings_of
from .model import Scene
from .nodes import Entry, ListNode, MapNode, Node, Scalar, given, kind_of, node_of
from .rule_type import RuleType
from .suggest import hint_inside, why_absent

SCENE = specs.ModelSpec(Scene)


class Unreachable(ValueError):
    """A path that leads to no setting; the message says why."""


def merge(base: Node | None, over: Node, spec: specs.Spec | None, rules: Mapping[str, RuleType]) -> Node:
    """``base`` with ``over`` laid over it, both being values of a setting ``spec`` (None: unknown).

    Raises Unreachable where ``over`` names a rule that a list in ``base`` does not hold.
    """
    if base is None or spec is None:
        return over
    if (
        isinstance(over, Scalar)
        and over.empty
        and isinstance(spec, specs.ModelSpec | specs.UnionSpec | specs.RulesSpec)
    ):
        return base
    if isinstance(spec, specs.RulesSpec) and isinstance(over, MapNode) and isinstance(base, ListNode):
        for name, entry in over.entries.items():  # the order stays; null takes a rule out
            base = _place_rule(base, [name], entry.node, rules)
        return base
    if not isinstance(base, MapNode) or not isinstance(over, MapNode):
        return over
    if isinstance(spec, specs.UnionSpec) and _kind(over, _kind(base, "")) != _kind(base, ""):
        return over  # another kind has other settings
    known = _specs(spec, over if isinstance(spec, specs.UnionSpec) and over.get("kind") else base, rules)
    if known is None:
        return over
    merged = dict(base.entries)
    for key, entry in over.entries.items():
        merged[key] = Entry(entry.mark, merge(base.get(key), entry.node, known.get(key), rules))
    return MapNode(merged, base.mark)


def merge_scenes(base: MapNode, over: MapNode, rules: Mapping[str, RuleType]) -> MapNode:
    """`merge` for whole presets."""
    merged = merge(base, over, SCENE, rules)
    assert isinstance(merged, MapNode)
    return merged


def place(root: MapNode, path: str, value: Node, rules: Mapping[str, RuleType]) -> MapNode:
    """``root``, a whole preset, with ``value`` laid over what is at ``path``; its marks are those of ``value``.

    ``path`` is dotted: keys, places in lists (from 0) or names of solids, and rules by name, `wind.strength` being
    short for `rules.wind.strength`; `wind[2]` is the second wind. A null takes an entry out of a list, and a rule out
    of the rules. Raises Unreachable.
    """
    parts = path.split(".")
    known = settings_of(Scene)
    if parts[0] not in known:
        rule = _rule_part(parts[0])[0]
        if rule not in rules:
            unknown = f"unknown key; {hint_inside(parts[0], [*known, *rules], rules)}"
            raise Unreachable(why_absent(path) or unknown)
        parts.insert(0, "rules")
    try:
        placed = _place(SCENE, root, parts, value, rules)
    except Unreachable as error:
        raise Unreachable(why_absent(path) or str(error)) from None
    assert isinstance(placed, MapNode)
    return placed


def _place(
    spec: specs.Spec, node: Node | None, parts: Sequence[str], value: Node, rules: Mapping[str, RuleType]
) -> Node:
    if not parts:
        return merge(node, value, spec, rules)
    if isinstance(node, Scalar) and (node.null or node.empty):
        node = None
    part = parts[0]
    if isinstance(spec, specs.ModelSpec | specs.UnionSpec):
        if node is None:
            node = MapNode({}, value.mark)
        if not isinstance(node, MapNode):
            raise Unreachable(f"{shown(part)} cannot be reached inside {kind_of(node)}")
        known = _specs(spec, node, rules)
        if known is None:
            raise Unreachable(f"{shown(part)} cannot be reached: the kind of its entry is not known")
        if part not in known:
            raise Unreachable(f"unknown key; {hint(part, known, 'the keys are')}")
        child = _place(known[part], node.get(part), parts[1:], value, rules)
        if isinstance(spec, specs.UnionSpec) and part == "kind":
            node = _of_kind(spec, node, child)
        old = node.entries.get(part)
        return node.with_entry(part, Entry(value.mark if len(parts) == 1 or old is None else old.mark, child))
    if isinstance(spec, specs.RulesSpec):
        return _place_rule(node, parts, value, rules)
    if isinstance(spec, specs.ParametersSpec) and len(parts) == 1 and (node is None or isinstance(node, MapNode)):
        return (node or MapNode({}, value.mark)).with_entry(part, Entry(value.mark, value))
    if isinstance(spec, specs.PanelsSpec):
        raise Unreachable("single panels are changed in the preset itself")
    if not isinstance(spec, specs.ItemsSpec | specs.VectorSpec | specs.ColourSpec | specs.SizeSpec | specs.NamesSpec):
        raise Unreachable("there is nothing inside this setting")
    if node is None and spec.default is not None:
        node = node_of(plain(spec.default), value.mark)
    if not isinstance(node, ListNode):
        raise Unreachable(f"{shown(part)} cannot be reached inside {'nothing' if node is None else kind_of(node)}")
    index = _index(node, part)
    item, before, after = node.items[index], node.items[:index], node.items[index + 1 :]
    if isinstance(spec, specs.ItemsSpec) and isinstance(value, Scalar) and value.null and len(parts) == 1:
        return ListNode((*before, *after), node.mark)
    inner: specs.Spec | None = None
    if isinstance(spec, specs.ItemsSpec):
        kinds = spec.kinds
        stand_in = next(iter(kinds.values()))
        inner = specs.UnionSpec(stand_in(), kinds) if spec.tagged else specs.ModelSpec(stand_in)
    elif len(parts) > 1:
        raise Unreachable("there is nothing inside a number")
    new = value if inner is None else _named(_place(inner, item, parts[1:], value, rules), item)
    return ListNode((*before, new, *after), node.mark)


def _named(node: Node, before: Node) -> Node:
    """An entry of a list with the name of the one whose place it takes, if it has none: the rest refer to it by
    that."""
    name = before.entries.get("name") if isinstance(before, MapNode) else None
    if name is None or not isinstance(node, MapNode) or "name" in node.entries:
        return node
    return node.with_entry("name", name)


def _place_rule(node: Node | None, parts: Sequence[str], value: Node, rules: Mapping[str, RuleType]) -> Node:
    """The node of `rules` with a change at parts[0], a rule, or inside of it."""
    name, count = _rule_part(parts[0])
    entries, removes = _listed(node), isinstance(value, Scalar) and value.null
    known = [place for place, (rule, _) in enumerate(entries) if rule]
    same = [place for place in known if entries[place][0] == name]
    if name.isdecimal() and len(name) < 7 and int(name) < len(known):
        at = known[int(name)]
    elif name not in rules:
        raise Unreachable(f"unknown rule {shown(name)}; {hint(name, rules, 'the rules are')}")
    elif count <= len(same):
        at = same[count - 1]
    elif len(parts) == 1 and count == len(same) + 1 and isinstance(value, MapNode):
        return _rules(node, [*entries, (name, Entry(value.mark, value))])
    else:
        have = ", ".join(entries[place][0] for place in known) or "none"
        times = f" {count} times" if count > 1 else ""
        more = "" if times or removes else f"; rules.{name}={{}} adds it"
        raise Unreachable(f"the preset does not list the rule {shown(name)}{times}; its rules are {have}{more}")
    name, entry = entries[at]
    if name not in rules:
        raise Unreachable(f"unknown rule {shown(name)}")
    if removes and len(parts) == 1:
        return _rules(node, [*entries[:at], *entries[at + 1 :]])
    if len(parts) == 1 and not isinstance(value, MapNode) and not (isinstance(value, Scalar) and value.empty):
        kind = f"must be a mapping of settings, not {given(value)}"
        raise Unreachable(f"{kind}; null takes the rule out: rules.{parts[0]}=null")
    inner = _place(specs.ModelSpec(rules[name].Parameters), entry.node, parts[1:], value, rules)
    return _rules(node, [*entries[:at], (name, Entry(entry.mark, inner)), *entries[at + 1 :]])


def _rules(before: Node | None, entries: list[tuple[str, Entry]]) -> Node:
    """`rules` with these entries: a mapping where they were one ``before`` and none is there twice, else a list."""
    mark = before.mark if isinstance(before, MapNode | ListNode) else entries[-1][1].mark
    if isinstance(before, MapNode) and len(dict(entries)) == len(entries):
        return MapNode(dict(entries), mark)
    return ListNode(tuple(MapNode({name: one}, one.mark) if name else one.node for name, one in entries), mark)


def _listed(node: Node | None) -> list[tuple[str, Entry]]:
    """The rules that `rules` holds, in the order of the text; what is none is there without a name."""
    if isinstance(node, MapNode):
        return [(name, entry) for name, entry in node.entries.items()
                if not (isinstance(entry.node, Scalar) and entry.node.null)]  # fmt: skip
    found: list[tuple[str, Entry]] = []
    for item in node.items if isinstance(node, ListNode) else ():
        if isinstance(item, MapNode) and len(item.entries) == 1:
            found += item.entries.items()
        elif isinstance(item, Scalar) and not item.empty and not item.null:
            found.append((item.text, Entry(item.mark, MapNode({}, item.mark))))
        else:
            found.append(("", Entry(item.mark, item)))
    return found


def _rule_part(part: str) -> tuple[str, int]:
    """`wind` -> wind, 1; `wind[2]` -> wind, 2."""
    numbered = re.fullmatch(r"(.+)\[([1-9][0-9]{0,5})\]", part)
    return (numbered[1], int(numbered[2])) if numbered else (part, 1)


def _index(node: ListNode, part: str) -> int:
    """The place in a list that ``part`` means: a number from 0, or the `name` of an item."""
    if part.isdecimal() and part.isascii() and len(part) < 7:
        if int(part) < len(node.items):
            return int(part)
        count = len(node.items)
        have = f"it has {count}, counted from 0" if count else "it is empty"
        raise Unreachable(f"there is no entry {part} in this list; {have}")
    known: dict[str, int] = {}
    for index, item in enumerate(node.items):
        name = item.get("name") if isinstance(item, MapNode) else None
        if isinstance(name, Scalar) and name.text:
            known.setdefault(name.text, index)
    if part in known:
        return known[part]
    unnamed = "none has a name; count them from 0" if node.items else "it is empty"
    have = hint(part, known, "the names are") if known else unnamed
    raise Unreachable(f"no entry of this list has the name {shown(part)}; {have}")


def _kind(node: MapNode, otherwise: str) -> str:
    kind = node.get("kind")
    return kind.text if isinstance(kind, Scalar) else otherwise


def _specs(spec: specs.Spec, node: MapNode, rules: Mapping[str, RuleType]) -> dict[str, specs.Spec] | None:
    """The specs of the keys that a mapping may have, or None where its kind is not known."""
    if isinstance(spec, specs.RulesSpec):
        return {name: specs.ModelSpec(rule.Parameters) for name, rule in rules.items()}
    if isinstance(spec, specs.UnionSpec):
        cls = spec.kinds.get(_kind(node, ""), None if node.get("kind") else type(spec.default))
    elif isinstance(spec, specs.ModelSpec):
        cls = spec.model
    else:
        return None
    return None if cls is None else {key: setting.spec for key, setting in settings_of(cls).items()}


def _of_kind(spec: specs.UnionSpec, node: MapNode, kind: Node) -> MapNode:
    """``node`` without the settings that another kind does not have."""
    cls = spec.kinds.get(kind.text) if isinstance(kind, Scalar) else None
    if cls is None:
        return node
    known = settings_of(cls)
    return node.without(*(key for key in node.entries if key not in known))
