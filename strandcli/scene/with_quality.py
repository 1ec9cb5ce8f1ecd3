"""A preset's `quality` put into effect: its settings are placed in the preset before that is validated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress

from .dump import plain
from .fields import settings_of
from .model import Scene
from .model.lights import MOST_LIGHTS
from .nodes import ListNode, MapNode, Node, Placed, Scalar, node_of, without_placed
from .quality import LOOKS, expanded
from .rule_type import RuleType
from .settings import SCENE, Unreachable, place
from .specs import ItemsSpec, ModelSpec, Refusal, Spec, as_number


def with_quality(root: MapNode, rules: Mapping[str, RuleType], beside: MapNode | None = None) -> MapNode:
    """``root``, a whole preset, with the settings that its `quality` stands for, in place of those of a quality that it
    had before. What is written ``beside`` it in the same file is kept, and what a look fixes stays its own.

    A quality that there is not changes nothing here, and neither does one at a place that is faulty: both are refused
    where values are read.
    """
    name = root.get("quality") if beside is None else beside.get("quality")
    if not isinstance(name, Scalar):
        return root
    cleared = without_placed(root)
    root = cleared if isinstance(cleared, MapNode) else MapNode({}, root.mark)
    lights = root.get("lights")
    if lights is None:
        lights = node_of(plain(settings_of(Scene)["lights"].spec.default), name.mark)
    items = lights.items[:MOST_LIGHTS] if isinstance(lights, ListNode) else ()
    shadowed = [i for i, light in enumerate(items) if not _is_off(_at(light, ["shadow", "model"]))]
    look = root.get("look")
    fixed = {one.path for one in LOOKS.get(look.text, ())} if isinstance(look, Scalar) else set()
    before = root
    for path, value in expanded(name.text, shadowed, lambda path: _number_at(before, path.split("."))):
        parts = path.split(".")
        if ".".join("*" if part.isdecimal() else part for part in parts) in fixed:
            continue
        if beside is None or _at(beside, parts) is None:
            with suppress(Unreachable):
                root = place(root, path, Placed(node_of(value, name.mark), _at(before, parts)), rules)
    return root


def _number_at(root: MapNode, parts: Sequence[str]) -> float | None:
    """The number at a path of a preset, or its default; None where there is neither, or a mapping on the way to it is
    absent."""
    spec: Spec = SCENE
    node: Node | None = root
    for part in parts:
        if isinstance(spec, ItemsSpec):
            items = node.items if isinstance(node, ListNode) else ()
            node = items[int(part)] if int(part) < len(items) else None
            spec = ModelSpec(next(iter(spec.kinds.values())))
            continue
        assert isinstance(spec, ModelSpec)
        absent = node is None or (isinstance(node, Scalar) and node.null)
        if absent and spec.default is None and spec is not SCENE:
            return None
        node = node.get(part) if isinstance(node, MapNode) else None
        spec = settings_of(spec.model)[part].spec
    if node is None or (isinstance(node, Scalar) and (node.null or node.empty)):
        return spec.default if isinstance(spec.default, int | float) else None
    try:
        return as_number(node) if isinstance(node, Scalar) else None
    except Refusal:
        return None


def _at(node: Node | None, parts: Sequence[str]) -> Node | None:
    """What is written at a path; None where nothing is."""
    for part in parts:
        if isinstance(node, ListNode) and part.isdecimal():
            node = node.items[int(part)] if int(part) < len(node.items) else None
        else:
            node = node.get(part) if isinstance(node, MapNode) else None
    return node


def _is_off(model: Node | None) -> bool:
    return isinstance(model, Scalar) and model.text == "off"
