"""What files of earlier runs tell, taken for no more than it can be: anybody may have written or damaged them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from .frames import frame_file

LARGEST = 1e300
"""Numbers beyond it, and integers that no float holds, are none that strandcli writes."""
MOST_FRAMES = 10**9
NUMBERS = ("seconds", "error", "counts")
"""What a frame tells by name in numbers."""


def is_number(value: object) -> bool:
    """Whether it is a finite number; truth values are none."""
    return type(value) in (int, float) and abs(value) <= LARGEST  # type: ignore[arg-type]


def is_number_or_none(value: object) -> bool:
    """Whether it is a finite number or None, which stands for one that is not known."""
    return value is None or is_number(value)


def sound_report(data: object) -> dict[str, Any] | None:
    """The report.json that this is, without what is of another type or names other files than frames' own; None
    where it is none."""
    if not isinstance(data, dict) or not isinstance(data.get("frames", []), list):
        return None
    checks: dict[str, Callable[[Any], Any]] = {
        "frames": lambda found: [_sound_frame(one) for one in found if _is_frame(one)],
        "preset": lambda found: {"name": "", **_texts(found, "name", "sha256")},
        "machine": lambda found: {key: one for key, one in _mapping(found).items() if is_told(one)} or None,
        "plan": lambda found: {part: _stages(_mapping(found).get(part)) for part in ("used", "left_out")},
        "totals": _numbers,
        "failure": lambda found: _texts(found, "message", "cause") or None,
        "warnings": lambda found: [one for one in found if isinstance(one, str)] if isinstance(found, list) else [],
        "compile_seconds": lambda found: found if is_number(found) else None,
        "picture_error": lambda found: _mapping(found) or None,
        **{key: lambda found: found if isinstance(found, str) else "" for key in ("strandcli", "status", "scene")},
    }
    return {key: checks[key](one) if key in checks else one for key, one in data.items()}


def is_told(value: object) -> bool:
    """Whether it is one of what a machine is told by: text, a number, or None."""
    return isinstance(value, str) or is_number_or_none(value)


def _is_frame(entry: object) -> bool:
    """Whether it tells of a frame by its number and the name of its file, which is the frame's own."""
    if not isinstance(entry, dict) or type(entry.get("frame")) is not int or not 0 <= entry["frame"] < MOST_FRAMES:
        return False
    return bool(entry.get("file") == frame_file(entry["frame"]))


def _sound_frame(entry: Mapping[str, Any]) -> dict[str, Any]:
    parts = {key: _numbers(entry[key]) for key in NUMBERS if key in entry}
    return {**{key: one for key, one in entry.items() if key not in parts}, **parts}


def _mapping(value: object) -> Mapping[str, Any]:
    return value if isinstance(value, dict) else {}


def _numbers(value: object) -> dict[str, Any]:
    return {key: one for key, one in _mapping(value).items() if is_number_or_none(one)}


def _texts(value: object, *keys: str) -> dict[str, str]:
    found = _mapping(value)
    return {key: found[key] for key in keys if isinstance(found.get(key), str)}


def _stages(value: object) -> list[dict[str, str]]:
    stages = [_texts(one, "stage", "why") for one in (value if isinstance(value, list) else [])]
    return [one for one in stages if len(one) == 2]
