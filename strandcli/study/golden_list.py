"""The list of golden images: what each shows, as ``golden.yaml`` says it.

A list of entries ::

    - preset: hair              # a shipped name, or a file beside golden.yaml
      name: hair                # optional; the preset's name, '/' as '-'
      frame: 12                 # optional; 1
      size: 160x120             # optional; the preset's own
      set: [emitter.strands=500]    # optional; as --set
      allow: 0.1                # optional; of a machine of another class, percent of pixels that may be off
      rmse: 1                   # optional; its greatest RMSE, of 255
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import RefusedError, UsageError

LIST = "golden.yaml"
_LARGEST = 1 << 20
"""Bytes of a list."""
MOST_OVER, MOST_RMSE = 0.001, 1.0
"""The tolerance of an image that states none: a share of all pixels, and of 255."""
NAME, SIZE = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*"), re.compile(r"([1-9][0-9]{0,4})x([1-9][0-9]{0,4})")
KEYS: Mapping[str, tuple[Callable[[Any], Any], str]] = {
    "preset": (lambda one: isinstance(one, str) and one, "a shipped name or a file"),
    "name": (lambda one: isinstance(one, str) and NAME.fullmatch(one), "letters, digits, '.', '_' or '-'"),
    "frame": (lambda one: type(one) is int and one >= 1, "a whole number from 1"),
    "size": (lambda one: isinstance(one, str) and SIZE.fullmatch(one), "a width and a height such as 160x120"),
    "set": (
        lambda one: isinstance(one, list) and all(isinstance(text, str) and "=" in text for text in one),
        "a list of texts such as 'wind.strength=3'",
    ),
    "allow": (lambda one: type(one) in (int, float) and 0 <= one <= 100, "a number from 0 to 100"),
    "rmse": (lambda one: type(one) in (int, float) and 0 <= one <= 255, "a number from 0 to 255"),
}
"""By key: whether a value is one, and what it must be."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One golden image: what to draw, and the name of its file without .png."""

    name: str
    preset: str
    overrides: tuple[str, ...] = ()
    frame: int = 1
    size: tuple[int, int] | None = None
    most_over: float = MOST_OVER
    most_rmse: float = MOST_RMSE


def read_entries(directory: Path) -> list[Entry]:
    """The list of a folder. Raises ``UsageError`` that names the entry at fault."""
    import yaml

    path = directory / LIST
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise UsageError(f"{path}: no such file; it lists the golden images, as in '- preset: hair'") from None
    except NotADirectoryError:
        raise UsageError(f"{directory}: is a file, not a folder of golden images") from None
    except PermissionError:
        raise RefusedError(f"{path}: no permission to read it") from None
    if len(data) > _LARGEST:
        raise UsageError(f"{path}: larger than {_LARGEST} bytes")
    try:
        found = yaml.safe_load(data)
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        raise UsageError(f"{path}: not YAML: {' '.join(str(error).split())}") from None
    if not isinstance(found, list) or not found:
        raise UsageError(f"{path}: must be a list of entries such as '- preset: hair'")
    entries = [_entry(one, f"{path}: entry {number}") for number, one in enumerate(found, 1)]
    names = [entry.name for entry in entries]
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f"{path}: two entries are named '{name}'; give one another 'name'")
    return entries


def _entry(data: Any, where: str) -> Entry:
    if not isinstance(data, dict):
        raise UsageError(f"{where}: must be a mapping such as 'preset: hair'")
    for key, value in {"preset": None, **data}.items():
        if key not in KEYS:
            raise UsageError(f"{where}: unknown key '{key}'; the keys are {', '.join(KEYS)}")
        is_sound, words = KEYS[key]
        if not is_sound(value):
            raise UsageError(f"{where}: '{key}' must be {words}, not {value!r}")
    preset = data["preset"]
    name = Path(preset).stem if preset.endswith((".yaml", ".yml")) else preset.replace("/", "-")
    wide, high = map(int, data["size"].split("x")) if "size" in data else (0, 0)
    return Entry(
        data.get("name", name), preset, tuple(data.get("set", ())), data.get("frame", 1),
        (wide, high) if wide else None, data.get("allow", 100 * MOST_OVER) / 100, float(data.get("rmse", MOST_RMSE)),
    )  # fmt: skip


def select(entries: Sequence[Entry], names: Sequence[str]) -> list[Entry]:
    """The entries of these names, or all if there are none. Raises ``UsageError`` for a name that is not there."""
    known = [entry.name for entry in entries]
    for name in names:
        if name not in known:
            raise UsageError(f"no golden image is named '{name}'; there are {', '.join(known)}")
    return [entry for entry in entries if not names or entry.name in names]
