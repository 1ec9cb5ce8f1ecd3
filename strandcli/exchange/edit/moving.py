"""What an edit did, and edits of strands that move: decided at the first moment, and made alike at all others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..strands import Attribute, Offsets, Points, Strands


@dataclass(frozen=True, slots=True)
class Change:
    """What an edit did: its name, a line for people, and the same as numbers."""

    edit: str
    text: str
    facts: dict[str, Any] = field(default_factory=dict)


Edit = Callable[[Strands], tuple[Strands, Change]]
ROW = "row of the point"
"""Attribute by which an edit that chooses among points is followed; no format has it."""


@dataclass(frozen=True, slots=True)
class Step:
    """An edit; ``chooses``: it leaves points out or turns their order around, and moves none."""

    edit: Edit
    chooses: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Replayed:
    """Edits that were made of strands, to be made of their points at other moments."""

    parts: Sequence[Offsets | tuple[Edit, Strands]]
    """Of each edit the points that it takes, or itself and the strands that it was made of."""

    def points(self, held: Points) -> Points:
        """The points (Q, 3) that become of points (P, 3)."""
        for part in self.parts:
            if isinstance(part, tuple):
                edit, strands = part
                held = edit(replace(strands, points=held, attributes={}))[0].points
            else:
                held = held[part]
        return held


def edited(
    strands: Strands, steps: Sequence[Step], again: bool = True
) -> tuple[Strands, list[Change], Replayed | None]:
    """Strands after all edits, what each did, and the same edits for other moments where they are asked for
    ``again``."""
    changes: list[Change] = []
    parts: list[Any] = []
    for step in steps:
        before = replace(strands, attributes={}) if again else None
        if again and step.chooses:
            rows = Attribute("point", np.arange(strands.points.shape[0]))
            strands = replace(strands, attributes={**strands.attributes, ROW: rows})
        strands, change = step.edit(strands)
        changes.append(change)
        if again and step.chooses:
            kept = dict(strands.attributes)
            parts.append(kept.pop(ROW).values)
            strands = replace(strands, attributes=kept)
        elif before is not None:
            parts.append((step.edit, before))
    return strands, changes, Replayed(parts) if again else None
