"""What an edit did."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True, slots=True)
class Change:
    """What an edit did: its name, a line for people, and the same as numbers."""

    edit: str
    text: str
    facts: dict[str, Any] = field(default_factory=dict)


def strands_of(count: int) -> str:
    """So many strands, in words."""
    return f"{count:,} strand{'' if count == 1 else 's'}"
