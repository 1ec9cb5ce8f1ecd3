"""Hashes of all that pictures of a scene follow from: settings, content of files, and this version of strandcli."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import __version__
from .errors import StrandError
from .inputs import digest_of, inputs_of, note
from .scene.model import Time
from .scene.named_files import named_file

if TYPE_CHECKING:
    from .scene.model import Scene

_LEFT_OUT = {
    "Scene": {"source", "sha256", "title"}, "RuleUse": {"path"}, "Time": {"frames"}, "Image": {"aovs"},
}  # fmt: skip
"""Fields by class that no pixel of a frame depends on: a longer film resumes a shorter one, and layers come and go."""


def fingerprint(scene: Scene, *more: str) -> str:
    """Hash of everything in a scene that changes the pixels of its frames, files that it names and that these name
    among it, and of this version of strandcli. Raises `UsageError` for a file that changed after it had been read."""
    data = json.dumps([__version__, scene_values(scene), *more], sort_keys=True, default=repr)
    return hashlib.sha256(data.encode()).hexdigest()[:32]


def scene_values(scene: Scene) -> dict[str, Any]:
    """Every setting of a scene that its pixels depend on, with hashes of files in place of their paths; ready for
    JSON."""
    found: dict[str, Any] = _values(scene)
    return found


def _values(thing: Any) -> Any:
    if dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        kind = type(thing).__name__
        found: dict[str, Any] = {"": kind, **({"period": thing.period} if isinstance(thing, Time) else {})}
        for field in dataclasses.fields(thing):
            if field.name in _LEFT_OUT.get(kind, ()):
                continue
            value = getattr(thing, field.name)
            file = named_file(field, value)
            found[field.name] = _values(value) if file is None else [Path(value).suffix, _content(value, file)]
        return found
    if isinstance(thing, tuple | list):
        return [_values(one) for one in thing]
    return thing


def _content(path: str, kind: str) -> dict[str, str]:
    """Hashes of a file, as ".", and of those that it names, by where they are from there; "" of one that is not there:
    what needs it says so. Where all of them lie makes no difference."""

    def read() -> None:
        with suppress(StrandError):  # likewise
            READERS[kind](path)

    return {os.path.relpath(one.path, path): digest_of(one) for one in inputs_of(path, read)}


def _strands(path: str) -> object:
    from .exchange.files import ReadOptions
    from .exchange.moments import read_first

    return read_first(Path(path), ReadOptions(lenient=True))


def _mesh(path: str) -> object:
    from .mesh_file.read import as_in_file

    return as_in_file(path)


def _cameras(path: str) -> object:
    from .cameras.read import views_of

    return views_of(Path(path), assumed=(1, 1))


READERS: dict[str, Callable[[str], object]] = {
    "strands": _strands, "mesh": _mesh, "cameras": _cameras, "picture": note,
}  # fmt: skip
"""By the kinds of file that settings name: what opens such a file, and all that it names."""
