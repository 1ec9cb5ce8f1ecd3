"""Numbers of things in words."""

from __future__ import annotations


def counted(count: int, one: str, several: str = "") -> str:
    """A number and what there are so many of: ``1 strand``, ``2,000 strands``; ``several``: the plural where it is not
    made by an s."""
    return f"{count:,} {one if count == 1 else several or f'{one}s'}"
