"""Presets as files: those that are shipped, found by name, the user's by path, and what each extends, laid one over the
other."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import StrandError, UsageError
from ..files.inputs import opened
from .faults import Fault, SceneError, fault_at, near, one_line, shown
from .nodes import MapNode, Node, Scalar, kind_of
from .rule_type import RuleType
from .settings import Unreachable, merge_scenes
from .yaml_source import LARGEST_FILE, read, read_value

if TYPE_CHECKING:
    import hashlib

SUFFIXES = (".yaml", ".yml")
DEEPEST_CHAIN = 8

Rules = Mapping[str, RuleType]
_read = lru_cache(maxsize=4)(read)
"""As `read`; a preset is looked at several times where it is drawn again and again."""


def folder() -> Path:
    """Where shipped presets are: in the installed package, or at the top of a checkout."""
    package = Path(__file__).resolve().parent.parent
    installed = package / "presets"
    return installed if installed.is_dir() else package.parent / "presets"


def list_presets() -> list[tuple[str, Path]]:
    """Name and path of every shipped preset, by name; those in a subfolder last, as ``figures/fig02``."""
    home = folder()
    found = [path for suffix in SUFFIXES for path in home.rglob(f"*{suffix}") if path.is_file()]
    named = [(path.relative_to(home).with_suffix("").as_posix(), path) for path in found]
    return sorted(named, key=lambda pair: (pair[0].count("/"), pair[0]))


def find(name: str) -> Path:
    """The shipped preset of this name. Raises UsageError, with a near name, where there is none."""
    presets = dict(list_presets())
    if name not in presets:
        raise UsageError(no_such_preset(name))
    return presets[name]


def no_such_preset(name: str, also: tuple[str, ...] = ()) -> str:
    """The message for a preset that is not there; ``also`` are names that might have been meant as well."""
    names = [shipped for shipped, _ in list_presets()]
    inside = (shipped for shipped in names if shipped.rpartition("/")[2] == name)  # fig02 for figures/fig02
    guess = next(inside, None) or near(name, [*also, *names])
    meant = f"did you mean {shown(guess)}? " if guess else ""
    if name.endswith(SUFFIXES):  # a path, which the list of shipped names does not help with
        return f"no preset {shown(name)}: there is no such file" + (f"; {meant.strip()}" if guess else "")
    return f"no preset {shown(name)}; {meant}`strandcli presets list` shows what is shipped"


def describe(path: Path) -> str:
    """What a preset shows, on one line: its ``title``, else its first comment, else nothing.

    Only these lines are read, so that a folder of presets is listed quickly, faulty ones too.
    """
    try:
        lines = path.read_text("utf-8-sig", errors="replace").splitlines()
    except OSError:
        return ""
    for line in lines:
        if title := re.match(r"title:\s+(.+)", line):
            try:
                value = read_value(title[1], str(path))
            except StrandError:
                break
            return one_line(value.text) if isinstance(value, Scalar) else ""
    comment = next((line.lstrip("# ").strip() for line in lines if line.startswith("#")), "")
    return one_line(comment)


def locate(given: str) -> Path:
    """The file of a preset: a shipped name, a path, or a path without its .yaml. Raises UsageError."""
    if not given.endswith(SUFFIXES) and (shipped := dict(list_presets()).get(given)):
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
        also = [p.name for p in path.parent.iterdir() if p.suffix in SUFFIXES] if path.name else []
    except (OSError, ValueError):
        also = []
    raise UsageError(no_such_preset(given, tuple(str(path.parent / name) for name in also)))


def hidden_by_shipped(given: str) -> Path | None:
    """The file beside that has the name of a shipped preset, which is taken in its place; None where there is none."""
    if given.endswith(SUFFIXES) or given not in dict(list_presets()):
        return None
    try:
        return _with_suffix(given)
    except (OSError, ValueError):
        return None


def _with_suffix(given: str) -> Path | None:
    """The file that a path without its suffix means; None where there is none."""
    if not given or given.endswith((*SUFFIXES, "/", ".")):
        return None
    return next((path for suffix in SUFFIXES if (path := Path(given + suffix)).is_file()), None)


def _bytes_of(path: Path) -> bytes:
    """A preset's bytes; one more than allowed where it is too large. Raises UsageError."""
    try:
        with opened(path) as file:
            return file.read(LARGEST_FILE + 1)
    except StrandError as error:
        raise UsageError(f"{shown(str(path))}: {str(error).removeprefix(f'{path}: ')}") from None


def chain_of(source: Path, rules: Rules, files: list[str], faults: list[Fault], digest: hashlib._Hash) -> MapNode:
    """The preset at ``source`` laid over all that it extends; ``files`` and ``faults`` are added to."""
    roots: dict[Path, MapNode] = {}
    path: Path | None = source
    while path is not None:
        data = _bytes_of(path)
        feed(digest, data)
        files.append(str(path))
        try:
            roots[path], found = _read(data, str(path))
        except SceneError as error:
            raise SceneError([*faults, *error.faults]) from None
        faults.extend(found)
        path = _parent(roots[path].get("extends"), list(roots), faults)
    root, *rest = (one.without("extends") for one in reversed(roots.values()))
    for over in rest:
        try:
            root = merge_scenes(root, over, rules)
        except Unreachable as problem:
            faults.append(fault_at(over.entries["rules"].mark, "rules", str(problem)))
    return root


def _parent(node: Node | None, paths: list[Path], faults: list[Fault]) -> Path | None:
    """The file that the last of some extends, by what it has under ``extends``; None where there is none, and with a
    fault where it cannot be."""
    if node is None or (isinstance(node, Scalar) and node.null):
        return None
    chain = " -> ".join(map(str, paths))
    if not isinstance(node, Scalar) or node.empty:
        problem = f"must be the name or the path of a preset, not {kind_of(node)}"
    else:
        try:
            path = _beside(paths[-1], node.text)
            if any(one.resolve() == path.resolve() for one in paths):
                problem = f"goes in a circle: {chain} -> {node.text}"
            elif len(paths) > DEEPEST_CHAIN:
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
    if extends.endswith(SUFFIXES):
        return locate(str(path.parent / extends))
    beside = _with_suffix(str(path.parent / extends))
    if beside is None or extends in dict(list_presets()):
        return find(extends)
    return beside


def feed(digest: hashlib._Hash, data: bytes) -> None:
    """Add ``data`` so that where one piece ends and the next begins makes a difference."""
    digest.update(len(data).to_bytes(8, "big") + data)
