"""What installed packages offer to strandcli under an entry-point group."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from .errors import UsageError


def offered(group: str, what: str) -> list[Any]:
    """The objects that installed packages name in a group. Raises `UsageError` for one that cannot be imported."""
    if not _named(group):
        return []
    from importlib.metadata import entry_points

    out = []
    for found in entry_points(group=group):
        try:
            out.append(found.load())
        except Exception as error:  # whatever another package raises while it is imported
            raise UsageError(f"{what} {found.name!r} ({found.value}) cannot be imported: {error}") from error
    return out


def _named(group: str) -> bool:
    """Whether any installed package names the group."""
    # a look at the files themselves: importlib.metadata takes a tenth of the time that `strandcli plan` may take, and
    # hardly anybody has such a package
    for folder in sys.path:
        for path in Path(folder or ".").glob("*-info/entry_points.txt"):
            try:
                if group in path.read_text(encoding="utf-8", errors="replace"):
                    return True
            except OSError:
                continue
    return False
