"""Files that are numbered by the frame: `strands.####.ply`, `strands.%04d.ply`."""

from __future__ import annotations

import os
import re
from pathlib import Path

PLACE = re.compile(r"#+|%(?:0([1-9]))?d")
LONGEST = 9
"""Digits of a number at most."""


def is_numbered(path: str | os.PathLike[str]) -> bool:
    """Whether a path stands for numbered files: its name has a place for a number, and no file has this name."""
    name = os.path.basename(path)
    return ("#" in name or "%" in name) and len(PLACE.findall(name)) == 1 and not os.path.lexists(path)


def numbered(path: Path) -> dict[int, Path]:
    """The files that a path stands for, by their numbers, which rise."""
    begin, end = PLACE.sub("\0", path.name).split("\0")
    form = re.compile(f"{re.escape(begin)}([0-9]{{1,{LONGEST}}}){re.escape(end)}")
    try:
        names = set(os.listdir(path.parent))
    except OSError:
        names = set()
    there = {int(one[1]) for name in names if (one := form.fullmatch(name))}
    return {number: file for number in sorted(there) if (file := file_of(path, number)).name in names}


def file_of(path: Path, number: int) -> Path:
    """The file of a number, whether it is there or not: of at least as many digits as the name has #."""
    place = PLACE.search(path.name)
    assert place is not None
    digits = int(place[1] or 1) if place[0].startswith("%") else len(place[0])
    return path.with_name(f"{path.name[: place.start()]}{number:0{digits}d}{path.name[place.end() :]}")
