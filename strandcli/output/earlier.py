"""Whether files of earlier runs are as strandcli writes them: anybody may have written or damaged them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .frames import frame_file

LARGEST = 1e300
"""Numbers beyond it, and integers that no float holds, are none that strandcli writes."""
MOST_FRAMES = 10**9


def is_number(value: object) -> bool:
    """Whether it is a finite number; truth values are none."""
    return type(value) in (int, float) and abs(value) <= LARGEST  # type: ignore[arg-type]


def is_number_or_none(value: object) -> bool:
    """Whether it is a finite number or None, which stands for one that is not known."""
    return value is None or is_number(value)


def _is_text(value: object) -> bool:
    return value is None or isinstance(value, str)


def _mapping(inner: Callable[[Any], bool]) -> Callable[[Any], bool]:
    """A check of mappings whose values are all of a kind, or of None."""
    return lambda value: value is None or (isinstance(value, dict) and all(map(inner, value.values())))


def _list(inner: Callable[[Any], bool]) -> Callable[[Any], bool]:
    return lambda value: isinstance(value, list) and all(map(inner, value))


def _is_told(value: object) -> bool:
    return _is_text(value) or is_number(value)


def _is_frame(entry: Any) -> bool:
    """Whether it tells of a frame by its number and the name of its file, which is the frame's own."""
    if not isinstance(entry, dict) or type(entry.get("frame")) is not int or not 0 <= entry["frame"] < MOST_FRAMES:
        return False
    numbers = _mapping(is_number_or_none)
    return bool(entry.get("file") == frame_file(entry["frame"])) and all(
        numbers(entry.get(name)) for name in ("seconds", "error", "counts")
    )


CHECKS: dict[str, Callable[[Any], bool]] = {
    "frames": _list(_is_frame),
    "preset": lambda value: (
        isinstance(value, dict) and isinstance(value.get("name"), str) and _mapping(_is_text)(value)
    ),
    "machine": _mapping(_is_told),
    "plan": _mapping(_list(lambda one: isinstance(one, dict) and {"stage", "why"} <= one.keys())),
    "totals": _mapping(is_number_or_none),
    "failure": _mapping(_is_told),
    "warnings": _list(lambda one: isinstance(one, str)),
    "compile_seconds": is_number_or_none,
    "picture_error": lambda value: value is None or isinstance(value, dict),
    **dict.fromkeys(("strandcli", "status", "scene"), _is_text),
}
"""By the keys of report.json."""


def sound_report(data: Any) -> dict[str, Any] | None:
    """The report.json that this is; None where a part of it is of another kind or names other files than frames'
    own."""
    if not isinstance(data, dict):
        return None
    return data if all(CHECKS[key](one) for key, one in data.items() if key in CHECKS) else None
