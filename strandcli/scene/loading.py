"""A preset's name or path to a `Scene`: files, ``extends``, ``--set``, panels, then validation of the whole."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from .checks import findings
from .faults import Fault, Mark, SceneError, fault_at, hint
from .library import chain_of, feed, locate
from .model import Scene
from .nodes import ListNode, MapNode, Node, Scalar, kind_of, marks_of, node_of
from .quality import settle, with_quality
from .rule_type import Check, RuleType, refusal
from .settings import Unreachable, place
from .specs import MOST_PANELS
from .validate import Reader
from .yaml_source import read, read_value

Rules = Mapping[str, RuleType]
Rank = Callable[[Mark], int]
"""Of a place: greater for what is laid over the rest, from the file that all extend to the command line."""


def load(
    name_or_path: str | os.PathLike[str],
    *,
    rules: Rules,
    overrides: Sequence[str] = (),
    settings: Mapping[str, Any] | None = None,
    option: str = "--set",
) -> Scene:
    """A preset as a validated scene.

    ``name_or_path`` is a path to a .yaml file or a shipped name (``hair``, ``figures/fig02``). ``rules`` are the rules
    that presets may use, by name. ``overrides`` are texts such as ``"wind.strength=3"``, as after ``--set``;
    ``settings`` the same with ready values, by dotted path. Both change the preset before its panels do. ``option``:
    what faults say that the texts follow.

    Raises `SceneError` with every fault in the order of the files, `UsageError` where there is no such preset.
    """
    import hashlib  # 2 ms, with OpenSSL behind it

    source = locate(os.fspath(name_or_path))
    digest = hashlib.sha256()
    faults: list[Fault] = []
    files: list[str] = []
    root = chain_of(source, rules, files, faults, digest)
    root = _override(root, [(one, f"{option} {one}") for one in overrides], settings or {}, rules, faults)
    scene = _whole(root, rules, faults, files)
    if faults:
        raise SceneError(_in_order(faults, files))
    for override in overrides:
        feed(digest, override.encode("utf-8", "surrogatepass"))
    for path, value in (settings or {}).items():
        feed(digest, f"{path}={value!r}".encode("utf-8", "surrogatepass"))
    name, sha256 = str(source), digest.hexdigest()
    panels = tuple(dataclasses.replace(panel, source=name, sha256=sha256) for panel in scene.panels)
    return dataclasses.replace(scene, panels=panels, source=name, sha256=sha256)


def loads(text: str, *, rules: Rules, name: str = "preset.yaml") -> Scene:
    """`load` for the text of a preset that extends nothing; ``name`` stands for the file in messages."""
    root, faults = read(text.encode("utf-8", "surrogatepass"), name)
    scene = _whole(root, rules, faults, [name])
    if faults:
        raise SceneError(_in_order(faults, [name]))
    return scene


def _override(
    root: MapNode, overrides: Sequence[tuple[str, str]], settings: Mapping[str, Any], rules: Rules, faults: list[Fault]
) -> MapNode:
    """``root`` with the settings of the command line, each with what faults call it, and of Python."""
    changes: list[tuple[str, Node]] = []
    for override, said in overrides:
        path, equals, text = override.partition("=")
        path = path.strip()
        mark = Mark(said)
        if not equals or not path:
            faults.append(fault_at(mark, "", "must be PATH=VALUE, such as wind.strength=3"))
            continue
        try:
            changes.append((path, read_value(text, mark.file)))
        except SceneError as error:
            faults.extend(error.faults)
    for path, value in settings.items():
        try:
            changes.append((path, node_of(value, Mark(""))))
        except TypeError as error:
            faults.append(Fault("", 0, 0, path, str(error)))
    for path, node in changes:
        try:
            root = place(root, _meant(path, node, root), node, rules)
        except Unreachable as problem:
            faults.append(fault_at(node.mark, path, str(problem)))
    return root


def _meant(path: str, node: Node, root: MapNode) -> str:
    """The path of a setting: a number of strands that no text asks for is that of the file's, where they are these."""
    emitter = root.get("emitter")
    groom = emitter.get("groom") if isinstance(emitter, MapNode) else None
    file = isinstance(groom, MapNode) and path == "emitter.strands" and not node.mark.file
    return "emitter.groom.strands" if file else path


def _whole(root: MapNode, rules: Rules, faults: list[Fault], files: Sequence[str]) -> Scene:
    """The scene of a complete tree with its panels, of ``files`` of which each extends the next; faults are added to
    ``faults``."""
    ranks = {file: -place for place, file in enumerate(files)}

    def rank(mark: Mark) -> int:
        return ranks.get(mark.file, 1)

    panels_entry = root.entries.get("panels")
    base = root.without("panels")
    scene, found = _one(base, rules, rank)
    faults.extend(found)
    if panels_entry is None or (isinstance(panels_entry.node, Scalar) and panels_entry.node.null):
        return scene
    if not isinstance(panels_entry.node, ListNode):
        given = kind_of(panels_entry.node)
        faults.append(fault_at(panels_entry.node.mark, "panels", f"must be a list of panels, not {given}"))
        return scene
    count = len(panels_entry.node.items)
    if count > MOST_PANELS:
        message = f"may have {MOST_PANELS} entries at the most, not {count:,}"
        faults.append(fault_at(panels_entry.node.mark, "panels", message))
        return scene
    known = {(fault.mark, fault.message) for fault in found}
    panels = []
    for index, node in enumerate(panels_entry.node.items):
        panel, wrong = _panel(base, node, f"panels.{index}", rules, known, rank)
        faults.extend(wrong)
        panels.append(panel)
    return dataclasses.replace(scene, panels=tuple(panel for panel in panels if panel is not None))


def _panel(
    base: MapNode, node: Node, path: str, rules: Rules, known: set[tuple[Mark, str]], rank: Rank
) -> tuple[Scene | None, list[Fault]]:
    """One panel's scene and its faults; ``known`` faults of the base are not reported again."""
    if not isinstance(node, MapNode):
        return None, [fault_at(node.mark, path, f"must be a mapping with `label` and `set`, not {kind_of(node)}")]
    faults = [
        fault_at(entry.mark, f"{path}.{key}", f"unknown key; {hint(key, ('label', 'set'), 'the keys are')}")
        for key, entry in node.entries.items()
        if key not in ("label", "set")
    ]
    root = base
    label = node.entries.get("label")
    if label is not None:
        root = root.with_entry("label", label)
    changes = node.get("set")
    if isinstance(changes, MapNode):
        for key, entry in changes.entries.items():
            where = f"{path}.set.{key}"
            if key.split(".")[0] in ("panels", "extends"):
                faults.append(fault_at(entry.mark, where, "a panel cannot have this; panels do not nest"))
                continue
            try:
                root = place(root, key, entry.node, rules)
            except Unreachable as problem:
                faults.append(fault_at(entry.mark, where, str(problem)))
    elif changes is not None and not (isinstance(changes, Scalar) and (changes.null or changes.empty)):
        faults.append(fault_at(changes.mark, f"{path}.set", f"must be a mapping of settings, not {kind_of(changes)}"))
    inside = set(marks_of(node))
    scene, found = _one(root, rules, lambda mark: 2 if mark in inside else rank(mark))
    for fault in found:
        if (fault.mark, fault.message) not in known:
            # what only together with the base is wrong is reported at the panel
            mark = fault.mark if fault.mark in inside else node.mark
            faults.append(fault_at(mark, f"{path}.set.{fault.path}", fault.message))
    return scene, faults


def _one(root: MapNode, rules: Rules, rank: Rank) -> tuple[Scene, list[Fault]]:
    """One scene without panels, and everything that is wrong with it."""
    reader = Reader(rules)
    scene: Scene = reader.model(Scene, root, "")
    scene, clashes = settle(with_quality(scene, reader.marks, rank), reader.marks)
    for path, message in clashes:
        reader.refuse(reader.mark_near(path) or root.mark, path, message)
    reported = [fault.path for fault in reader.faults]
    for finding in findings(scene):
        if not any(_touches(path, about) for path in reported for about in finding.involves or finding.places):
            path = next((place for place in finding.places if place in reader.marks), finding.places[0])
            reader.refuse(reader.mark_near(path) or root.mark, path, finding.message)
    for use in scene.rules:
        if message := refusal(use.name, scene.solver):
            reader.refuse(reader.mark_near(use.path) or root.mark, use.path, message)
    if any(_shakes_solids(path) for path in reported):
        return scene, reader.faults
    for use in scene.rules:
        check: Check | None = getattr(rules[use.name], "check", None)
        if check is None or any(_touches(path, use.path) for path in reported):
            continue
        for inner, message in check(use.parameters, scene):
            path = f"{use.path}.{inner}" if inner else use.path
            reader.refuse(reader.mark_near(path) or root.mark, path, message)
    return scene, reader.faults


def _touches(path: str, other: str) -> bool:
    """Whether one path is the other or lies inside of it."""
    return path == other or path.startswith(f"{other}.") or other.startswith(f"{path}.")


def _shakes_solids(path: str) -> bool:
    """Whether a fault at ``path`` leaves open which solids there are, which rules' checks may ask for."""
    parts = path.split(".")
    return parts[0] == "solids" and (len(parts) < 3 or parts[2] in ("kind", "name"))


def _in_order(faults: Iterable[Fault], files: Sequence[str]) -> list[Fault]:
    """Each fault once, by file, line and column; what stands in no file (--set, Python) comes last."""
    places = {file: place for place, file in enumerate(files)}
    return sorted(dict.fromkeys(faults), key=lambda f: (places.get(f.file, len(files)), f.line, f.column))
