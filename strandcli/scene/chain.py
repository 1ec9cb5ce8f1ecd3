"""The file of a preset, and the presets that it extends, laid one over the other."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from ..errors import StrandError, UsageError
from ..files.inputs import opened
from . import library
from .faults import Fault, SceneError, fault_at, shown
from .nodes import MapNode, Scalar, kind_of
from .rule_type import RuleType
from .settings import Unreachable, merge_scenes
from .yaml_source import LARGEST_FILE, read

if TYPE_CHECKING:
    import hashlib

DEEPEST_CHAIN = 8

Rules = Mapping[str, RuleType]


def locate(given: str) -> Path:
    """The file of a preset: a shipped name, a path, or a path without its .yaml. Raises UsageError."""
    if not given.endswith(library.SUFFIXES):
        for name, shipped in library.list_presets():
            if name == given:
                return shipped
    path = Path(given)
    try:
        if path.is_file():
            return path
        if beside := _with_suffix(given):
            return beside
        if path.is_dir():
            raise UsageError(f"{shown(given)} is a folder; a preset is a .yaml file")
        if path.is_symlink() or path.exists():
            raise UsageError(f"{shown(given)} is a device, a pipe or a link to nowhere; a preset is a .yaml file")
        others = [p.name for p in path.parent.iterdir() if p.suffix in library.SUFFIXES] if path.name else []
    except (OSError, ValueError):
        others = []
    raise UsageError(library.no_such_preset(given, tuple(str(path.parent / name) for name in others)))


def hidden_by_shipped(given: str) -> Path | None:
    """The file beside that has the name of a shipped preset, which is taken in its place; None where there is none."""
    if given.endswith(library.SUFFIXES) or all(name != given for name, _ in library.list_presets()):
        return None
    try:
        return _with_suffix(given)
    except (OSError, ValueError):
        return None


def _with_suffix(given: str) -> Path | None:
    """The file that a path without its suffix means; None where there is none."""
    if not given or given.endswith((*library.SUFFIXES, "/", ".")):
        return None
    return next((path for suffix in library.SUFFIXES if (path := Path(given + suffix)).is_file()), None)


def _bytes_of(path: Path) -> bytes:
    """A preset's bytes; one more than allowed where it is too large. Raises UsageError."""
    try:
        with opened(path) as file:
            return file.read(LARGEST_FILE + 1)
    except StrandError as error:
        raise UsageError(f"{shown(str(path))}: {str(error).removeprefix(f'{path}: ')}") from None


class _Link(NamedTuple):
    """One file of a chain of presets that extend each other."""

    path: Path
    root: MapNode


def chain_of(source: Path, rules: Rules, files: list[str], faults: list[Fault], digest: hashlib._Hash) -> MapNode:
    """The preset at ``source`` laid over all that it extends; ``files`` and ``faults`` are added to."""
    links: list[_Link] = []
    path: Path | None = source
    while path is not None:
        data = _bytes_of(path)
        feed(digest, data)
        files.append(str(path))
        try:
            root, found = _read(data, str(path))
        except SceneError as error:
            raise SceneError([*faults, *error.faults]) from None
        faults.extend(found)
        links.append(_Link(path, root))
        path = _parent(links, faults)
    links.reverse()
    root = links[0].root.without("extends")
    for link in links[1:]:
        try:
            root = merge_scenes(root, link.root.without("extends"), rules)
        except Unreachable as problem:
            entry = link.root.entries["rules"]
            faults.append(fault_at(entry.mark, "rules", str(problem)))
    return root


@lru_cache(maxsize=4)
def _read(data: bytes, file: str) -> tuple[MapNode, list[Fault]]:
    """As `read`; a preset is looked at several times where it is drawn again and again."""
    return read(data, file)


def _parent(links: list[_Link], faults: list[Fault]) -> Path | None:
    """The file that the last link extends, or None; a fault where it cannot be."""
    last = links[-1]
    node = last.root.get("extends")
    if node is None or (isinstance(node, Scalar) and node.null):
        return None
    chain = " -> ".join(str(link.path) for link in links)
    problem = ""
    if not isinstance(node, Scalar) or node.empty:
        given = kind_of(node)
        problem = f"must be the name or the path of a preset, not {given}"
    else:
        try:
            path = _beside(last.path, node.text)
            same = [link for link in links if link.path.resolve() == path.resolve()]
            if same:
                problem = f"goes in a circle: {chain} -> {node.text}"
            elif len(links) > DEEPEST_CHAIN:
                problem = f"goes more than {DEEPEST_CHAIN} deep: {chain} -> {node.text}"
            else:
                _bytes_of(path)
                return path
        except UsageError as error:
            problem = str(error)
    faults.append(fault_at(node.mark, "extends", problem))
    return None


def _beside(path: Path, extends: str) -> Path:
    """What ``extends`` means in the file at ``path``."""
    if extends.endswith(library.SUFFIXES):
        return locate(str(path.parent / extends))
    beside = _with_suffix(str(path.parent / extends))
    if beside is None or any(name == extends for name, _ in library.list_presets()):
        return library.find(extends)
    return beside


def feed(digest: hashlib._Hash, data: bytes) -> None:
    """Add ``data`` so that where one piece ends and the next begins makes a difference."""
    digest.update(len(data).to_bytes(8, "big") + data)
