"""What a kernel is made of: the text of its module and of every module of this package that it imports,
directly or not.

Numba compares one file with its cache, and does not see that a function in another file has changed.
"""

from __future__ import annotations

import functools
import hashlib
import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from numba.core import types

PACKAGE = __name__.split(".")[0]
ROOT = str(Path(__file__).parents[1])
IMPORT = re.compile(rb"from[ \t]+(\.*[\w.]*)[ \t]+import[ \t]+(\([^)]*\)|[^\n]+)")
NOT_COMPILED = frozenset(
    f"{PACKAGE}.{name}" for name in (
        "jit.cache", "jit.dispatcher", "jit.sources", "compiling", "errors",
    )
)  # fmt: skip
"""Modules, or all of a package, that decide where kernels are stored and when they are compiled, not what they are."""


@functools.cache
def digest(module: str) -> str:
    """SHA-256 of the module's text and of all that it imports of this package, as hexadecimal digits."""
    found: set[str] = set()
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name in found or name in NOT_COMPILED or name.rpartition(".")[0] in NOT_COMPILED:
            continue
        found.add(name)
        waiting += [one for one in _imported(name) if one not in found]
    whole = hashlib.sha256()
    for name in sorted(found):
        whole.update(name.encode() + b"\0" + _hash(name))
    return whole.hexdigest()


def digests_of_types(signature: Any) -> tuple[str, ...]:
    """The digests of the modules of all named tuples that a kernel is given: which functions it calls may follow from
    their classes, and two classes of one name would have one signature."""
    found: list[str] = []
    waiting = list(signature)
    while waiting:
        one = waiting.pop(0)
        if isinstance(one, types.BaseNamedTuple):
            module = one.instance_class.__module__  # type: ignore[attr-defined]
            found.append(f"{module} {digest(module)}")
        if isinstance(one, types.BaseTuple):
            waiting += list(one)  # type: ignore[call-overload]
        elif isinstance(one, types.Optional):
            waiting.append(one.type)
    return tuple(found)


@functools.cache
def _hash(module: str) -> bytes:
    """SHA-256 of a module's own text."""
    return hashlib.sha256(_text(module)).digest()


@functools.cache
def _text(module: str) -> bytes:
    """The text of a module: of its file, or, where a generated one could not be written to a file, as it holds it."""
    text = getattr(sys.modules.get(module), "__strandcli_text__", None)
    if text is not None:
        return bytes(text)
    path = _path(module)
    return b"" if path is None else path.read_bytes()


@functools.cache
def _path(module: str) -> Path | None:
    """The file of a module: of this package by its name, of another by what Python has loaded."""
    package, _, name = module.rpartition(".")
    if module.split(".")[0] == PACKAGE:
        where = os.path.dirname(ROOT) + "/" + package.replace(".", "/")
        there = _names(where)
        if f"{name}.py" in there:
            return Path(where, f"{name}.py")
        inner = f"{where}/{name}"
        return Path(inner, "__init__.py") if name in there and "__init__.py" in _names(inner) else None
    file = getattr(sys.modules.get(module), "__file__", None)
    return None if file is None else Path(file)


@functools.cache
def _names(folder: str) -> frozenset[str]:
    """What is in a folder; nothing where there is none. Most names that modules import are no modules, and each would
    be looked for."""
    try:
        return frozenset(os.listdir(folder))
    except OSError:
        return frozenset()


@functools.cache
def _imported(module: str) -> list[str]:
    """Modules of this package, and of the module's own, that its text imports."""
    path = _path(module)
    package = module.split(".") if path is not None and path.name == "__init__.py" else module.split(".")[:-1]
    found = []
    for source, names in _statements(_text(module)):
        where = source.decode()
        dots = len(where) - len(where.lstrip("."))
        parts = [part for part in where.lstrip(".").split(".") if part]
        if dots:
            parts = package[: len(package) - dots + 1] + parts
        if not parts or parts[0] not in (PACKAGE, module.split(".")[0]):
            continue
        base = ".".join(parts)
        wanted = re.findall(r"(\w+)(?:[ \t]+as[ \t]+\w+)?", names.decode())
        modules = [one for name in wanted if _path(one := f"{base}.{name}") is not None]
        found += modules
        if len(modules) < len(wanted) and _path(base) is not None:  # something of what the package itself says
            found.append(base)
    return found


def _statements(text: bytes) -> Iterator[tuple[bytes, bytes]]:
    """From where, and what, the import statements of a module's text import."""
    place = text.find(b"from")
    while place >= 0:
        line = text.rfind(b"\n", 0, place) + 1
        found = IMPORT.match(text, place) if not text[line:place].strip(b" \t") else None
        if found is not None:
            yield found[1], found[2]
        place = text.find(b"from", found.end() if found is not None else place + 1)
