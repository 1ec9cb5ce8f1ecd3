"""Settings of a file that is turned, scaled and placed, which solids, emitters and strands of a file share.

They are fields and no base class: slots of two bases do not go together, and solids have a base of their own.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..faults import Finding
from ..fields import choice, number

AXES = ("x", "y", "z", "-x", "-y", "-z")


def up(auto: str = "") -> Any:
    """The up axis of a file; ``auto``: what is done where none is given, if not to take y."""
    doc = "up axis of the file, which becomes y"
    return choice("auto", ("auto", *AXES), doc=f"{doc}. auto: {auto}") if auto else choice("y", AXES, doc=doc)


def scale(absent: str = "1") -> Any:
    """Metres a unit of the file."""
    return number(None, above=0, unit="1", doc=f"metres a unit of the file; absent: {absent}")


def size(box: str = "its box") -> Any:
    """Longest side, in place of a scale."""
    return number(None, above=0, unit="m", doc=f"longest side of {box}, in place of `scale`; absent: by scale")


def place(where: str = "it is", box: str = "its box") -> Any:
    """Where what the file holds is put."""
    return choice(
        "file",
        ("file", "origin", "ground"),
        doc=f"file: where {where} in the file; origin: the middle of {box} at the origin; ground: above it, the lowest "
        "point at y = 0",
    )


def both_sizes(path: str, given: Any) -> Iterator[Finding]:
    """Yield the clash of a scale and a size where settings at a path have both."""
    if given.size is not None and given.scale is not None:
        message = f"clashes with {path}.size, which sets the same; set one to null"
        yield Finding((f"{path}.scale", f"{path}.size"), message)
