"""Settings that presets had once, and what to do instead."""

from __future__ import annotations

from collections.abc import Mapping

from .faults import shown

GONE: Mapping[str, tuple[str, str]] = {
    "rod.yield_strain": ("0.1.0", "strands spring back to their rest shape; take it out"),
}
"""By dotted path, with the value where only that is gone: the last version that had it, and what to do instead."""


def why_gone(path: str, value: str = "") -> str | None:
    """Return why there is no setting at a dotted path any more, or around it, or no such ``value`` of it; None where
    there never was."""
    if value:
        found = GONE.get(f"{path}: {value}")
        return None if found is None else f"{shown(value)} is gone after {found[0]}; {found[1]}"
    while path and path not in GONE:
        path = path.rpartition(".")[0]
    return f"gone after {GONE[path][0]}; {GONE[path][1]}" if path else None
