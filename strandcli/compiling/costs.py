"""Which kernels the shipped presets need, and the seconds that compiling each took where `make kernel-costs` ran."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

FILE = Path(__file__).with_name("costs.json")
USUAL = 1.0
"""Seconds of a kernel that was not measured."""


def kernels_of(source: str) -> Counter[str]:
    """The kernels of the shipped preset in a file, by how many signatures of each it needs; none of other files, nor of
    a scene that is of no file, whose source is ""."""
    presets = _table()["presets"]
    path = Path(source).as_posix()
    return next((Counter(found) for name, found in presets.items() if path.endswith(f"presets/{name}.yaml")), Counter())


def seconds_of(kernels: Counter[str]) -> float:
    """What compiling them took."""
    known = _table()["seconds"]
    return sum(known.get(name, USUAL) * count for name, count in kernels.items())


def _table() -> dict[str, Any]:
    try:
        return dict(json.loads(FILE.read_text(encoding="utf-8")))
    except (OSError, ValueError):
        return {"seconds": {}, "presets": {}}
