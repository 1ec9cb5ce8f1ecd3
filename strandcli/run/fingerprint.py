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

from .. import __version__
from ..errors import StrandError
from ..files.inputs import digest_of, inputs_of, note
from ..scene.model import Time
from ..scene.named_files import named_file
from ..scene.rule_type import MUTUAL

if TYPE_CHECKING:
    from ..scene.model import Scene

_LEFT_OUT = {
    "Scene": {"source", "sha256", "title"}, "RuleUse": {"path"}, "Time": {"frames"}, "Image": {"aovs"},
    "Emitter": {"extent"},
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


ONLY_DRAWN = frozenset(
    ("camera", "image", "lights", "ambient", "environment", "ambient_occlusion", "material", "curves", "detail",
     "children", "look", "quality", "label", "panels")
)  # fmt: skip
"""Settings of a scene that no strand's motion depends on: any other one counts."""
_ONLY_DRAWN = {
    "emitter": {"followers"}, "groom": {"colours", "cover"}, "shape": {"colours"},
    "solids": {"colour", "coat", "roughness", "mottle", "grain", "subsurface", "visible", "colour_from", "texture",
               "crease", "fade"},
}  # fmt: skip
"""Settings within mappings, by the name of these."""


def motion_values(scene: Scene) -> dict[str, Any]:
    """Every setting of a scene that the motion of its strands depends on, as JSON has `scene_values`."""
    found = {name: _moving(name, one) for name, one in scene_values(scene).items() if name not in ONLY_DRAWN}
    if any(use.name in MUTUAL for use in scene.rules):  # strands stand for their children
        found["children"] = scene.children.count if scene.children else 1
    return dict(json.loads(json.dumps(found, default=repr)))


def motion_fingerprint(values: dict[str, Any]) -> str:
    """Hash of `motion_values` and of this version of strandcli."""
    return hashlib.sha256(json.dumps([__version__, values], sort_keys=True, default=repr).encode()).hexdigest()[:32]


def difference(one: Any, other: Any) -> str:
    """The key of the first setting that two sets of values, as JSON has them, do not share; "" where they are the
    same, "." for the whole."""
    if one == other:
        return ""
    if isinstance(one, dict) and isinstance(other, dict) and one.get("") == other.get(""):
        for key in sorted(one.keys() | other.keys()):
            if found := difference(one.get(key, ...), other.get(key, ...)):
                if key == "parameters" and one.get("") == "RuleUse":
                    key = one["name"]
                rule = key == "rules" and found != "."  # whose name is a key by itself
                return found if rule else key if found == "." else f"{key}.{found}"
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        for number, (mine, theirs) in enumerate(zip(one, other, strict=True)):
            if (found := difference(mine, theirs)) not in ("", "."):
                return found if mine[""] == "RuleUse" else f"{number}.{found}"
    return "."


def _moving(name: str, values: Any) -> Any:
    if isinstance(values, list):
        return [_moving(name, one) for one in values]
    if not isinstance(values, dict):
        return values
    return {key: _moving(key, one) for key, one in values.items() if key not in _ONLY_DRAWN.get(name, ())}


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
    from ..exchange.files import ReadOptions, files_of, read

    first, *rest = files_of(Path(path))
    for one in (Path(path), *rest):
        note(one)
    return inputs_of(first, lambda: read(first, ReadOptions(lenient=True)))


def _mesh(path: str) -> object:
    from ..mesh_file.read import as_in_file

    return as_in_file(path)


def _cameras(path: str) -> object:
    from ..cameras.read import views_of

    return views_of(Path(path), assumed=(1, 1))


READERS: dict[str, Callable[[str], object]] = {
    "strands": _strands, "mesh": _mesh, "cameras": _cameras, "picture": note,
}  # fmt: skip
"""By the kinds of file that settings name: what opens such a file, and all that it names."""
