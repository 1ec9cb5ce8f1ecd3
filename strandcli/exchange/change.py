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
