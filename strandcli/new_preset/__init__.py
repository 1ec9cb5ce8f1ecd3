"""Presets that `strandcli new` writes: commented (`text`), and drawn as they are, for files of strands and of meshes
are placed by their unit and up axis, as files tell them or as they are guessed."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import UsageError

HEAD_SIZE = 0.28
"""Metres: longest side of a head without shoulders, for meshes of no known unit."""
GROOM_SIZE = 0.4
"""Likewise of strands that hang from one."""
DENSITIES = ("scalp", "density", "hair", "fur")
"""Attributes of vertices that tell where strands grow."""
TOLD = "metres a unit, as the file says"
UNKNOWN = "of the file; there is no evidence, so look at the picture"
COLUMN = 22
"""Width of a key with its value, before a comment."""


@dataclass(frozen=True, slots=True)
class Placed:
    """A file with the lines of its placing.

    file: its path as the preset names it; lines: `up`, `scale` or `size`, with comments; size: longest side, metres;
    density: the attribute by which strands grow on it.
    """

    file: str
    lines: tuple[str, ...]
    size: float
    up: str
    scale: float
    density: str | None = None


def named(path: Path, preset: Path) -> str:
    """A file's path as a preset names it: from the preset's folder where it lies there, below or beside it."""
    try:
        near = Path(os.path.relpath(path.resolve(), preset.parent.resolve()))
    except ValueError:  # on another drive
        near = path.resolve()
    found = near if near.parts.count("..") < 2 else path.resolve()
    text = found.as_posix()
    if not text.isprintable():
        raise UsageError(f"{path}: its name has characters that a preset cannot have; rename it")
    return text


def mesh(path: Path, preset: Path) -> Placed:
    """A mesh placed by what its file tells, else by guesses. Raises `UsageError` where it cannot be read."""
    from ..meshes.facts import facts_of_file

    data, _ = facts_of_file(path)
    guess = data["guess"]
    names = {one["name"] for one in data["attributes"] if one["domain"] == "vertex"}
    density = next((name for name in DENSITIES if name in names), None)
    up = guess["up"], "it stands on a flat side"
    return _placed(named(path, preset), data, up, guess["unit"], HEAD_SIZE, density)


def strands(path: Path, preset: Path) -> Placed:
    """Strands placed by what their file tells, else by guesses."""
    from ..exchange.facts import facts_of_file
    from ..exchange.files import ReadOptions

    data = facts_of_file(path, ReadOptions())
    if data["box"] is None:
        raise UsageError(f"{path}: has no strand that could be drawn; 'strandcli info {path}' describes it")
    up = data["guess"]["up"]
    return _placed(named(path, preset), data, (up and up["axis"], "hair hangs from above"), None, GROOM_SIZE)


def _placed(
    file: str, data: Mapping[str, Any], up: tuple[str | None, str], unit: Mapping[str, Any] | None, usual: float,
    density: str | None = None,
) -> Placed:  # fmt: skip
    """A file placed by its facts; ``up``: the guess, and why; ``usual``: its size where nothing tells the unit."""
    axes: tuple[tuple[Any, str], ...] = ((data["up"], "as the file says"), (up[0], f"a guess: {up[1]}"), ("y", UNKNOWN))
    axis, why_up = next(pair for pair in axes if pair[0])
    size, scale = max(data["box"]["size"]), data["unit"] or (unit and unit["scale"])
    guess = "" if data["unit"] or not unit else f", a guess: it is in {unit['unit']}"
    why = f"metres a unit{guess}" if guess else TOLD
    found = float(scale) if scale else usual / size
    return Placed(file, _lines(axis, why_up, found, why, 0 if scale else usual), found * size, axis, found, density)


def strands_on(path: Path, head: Placed, head_file: Path, preset: Path) -> tuple[Placed, str | None]:
    """Strands placed by how their roots lie on a placed mesh, and what to do where they lie on it in no way."""
    from ..exchange.files import ReadOptions
    from ..groom_file import fits  # Numba comes with it
    from ..solid_shapes.mesh import Settings

    solid = Settings(file=str(head_file), up=head.up, scale=head.scale)
    fit = fits.facts_on(path, ReadOptions(lenient=True), solid)
    found = fit["mend"] or fit
    up, scale = found["up"], found["scale"]
    why = f"measured: roots lie {found['median']:.2g} m off the head in the median"
    warning = None
    if not fit["fits"] and fit["mend"] is None:
        why = "not sure: roots lie off the head"
        warning = f"{path}: {fits.said(fit)}"
    return Placed(named(path, preset), _lines(up, why, scale, why, 0), 0.0, up, scale), warning


def _lines(up: str, why_up: str, scale: float, why: str, size: float) -> tuple[str, ...]:
    """`up`, and `size` where one is given, else `scale`."""
    second = f"{f'scale: {scale:.6g}':<{COLUMN}} # {why}"
    if size:
        second = f"{f'size: {size:g}':<{COLUMN}} # metres, its longest side; the unit is not known"
    return f"{f'up: {up}':<{COLUMN}} # {why_up}", second
