"""The strands of a scene's file: read, mended, turned, scaled, placed, and packed for drawing."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import UsageError
from ..exchange import faults
from ..exchange.change import strands_of
from ..exchange.edit.fix import fixed, reversed_all
from ..exchange.edit.subsample import some
from ..exchange.edit.transform import scaled, turned
from ..exchange.ends import ends, up_axis
from ..exchange.files import ReadOptions, read
from ..exchange.strands import CHUNK, Strands
from ..groom.arrange import near
from ..groom.emit import stream
from ..groom.record import Groom
from .measure import Seen, seen_of
from .rows import packed
from .widths import widths_of

if TYPE_CHECKING:
    from ..scene.model import GroomFile

UP = "y"
"""The up axis of scenes."""
TONES = 5
"""Number of the random stream of tones, as `strandcli.groom.emit` has it."""


@dataclass(frozen=True, eq=False)
class FromFile:
    """The strands of a file in the emitter's frame."""

    groom: Groom
    points: int
    """Of every strand, as it is drawn."""
    seen: Seen
    width: float | None
    """Metres, the mean of the file's own; None where it has none."""
    notes: tuple[str, ...]
    """What a person should know of the file, a line each."""


def from_file(given: GroomFile, seed: int) -> FromFile:
    """The strands that a scene's ``emitter.groom`` asks for. Raises `UsageError`, one line, for a file that is damaged
    or cannot be drawn. The last one is kept, as long as the file does not change."""
    try:
        found = os.stat(given.file)
    except OSError as error:
        raise UsageError(f"{given.file}: cannot be read: {error.strerror or error}") from None
    drawn = {"cover": None}  # what does not change the strands
    return _from_file(replace(given, **drawn), seed, found.st_mtime_ns, found.st_size)  # type: ignore[arg-type]


@lru_cache(maxsize=1)
def _from_file(given: GroomFile, seed: int, changed: int, size: int) -> FromFile:
    notes: list[str] = []
    strands = _read(given, seed, notes)
    strands = _placed(_upright(strands, given, notes), given)
    widths = widths_of(strands, notes)
    roots, lengths = strands.roots(), strands.lengths()
    order = near(roots)
    counts = strands.counts()
    most = int(counts.max())
    if counts.min() < most:
        notes.append(
            f"{given.file}: strands have {counts.min():,} to {most:,} points; shorter ones get more on their segments"
        )
    seen = seen_of(strands)
    points = packed(strands.first, strands.points, order, most)
    way = strands.points[strands.first[:-1] + 1].astype(np.float64) - roots
    groom = Groom(
        roots[order],
        _units(way)[order].astype(np.float32),
        lengths[order].astype(np.float32),
        (2.0 * stream(seed, TONES, strands.count) - 1.0).astype(np.float32)[order],
        places=order,
        points=points,
        widths=None if widths is None else widths.scale[order],
    )
    return FromFile(groom, most, seen, None if widths is None else widths.mean, tuple(notes))


def _read(given: GroomFile, seed: int, notes: list[str]) -> Strands:
    """The file's strands in its own frame, root to tip, without those that cannot be drawn."""
    path = Path(given.file)
    strands = read(path, ReadOptions(given.stride, given.array or None, lenient=given.fix))
    notes += [f"{path}: {strands_of(count)} of {why}, skipped" for why, count in strands.source.skipped.items()]
    if given.fix:
        before = strands
        strands, change = fixed(strands, given.root == "auto")
        if strands is not before:
            notes.append(f"{path}: {change.text}")
    if given.root == "last":
        strands, _ = reversed_all(strands)
    if given.strands is not None and given.strands < strands.count:
        strands, _ = some(strands, given.strands, seed)
    if not strands.count:
        raise UsageError(f"{path}: holds no strand that could be drawn")
    bare = faults.without_length(strands)
    if bare.any():
        raise UsageError(
            f"{path}: {strands_of(int(bare.sum()))} without length (strand {int(np.argmax(bare)):,} for one); set "
            "emitter.groom.fix: true, which leaves them out"
        )
    return strands


def _upright(strands: Strands, given: GroomFile, notes: list[str]) -> Strands:
    """Strands whose up axis is y."""
    up = given.up
    if up == "auto":
        up = strands.source.up or UP
        known = None if strands.source.up else ends(strands)
        guess = None if known is None else up_axis(strands, known)
        if guess is not None and guess[0] != up:
            up = guess[0]
            notes.append(f"{given.file}: up is taken to be {up}, which becomes y; emitter.groom.up says otherwise")
    return strands if up == UP else turned(strands, up, UP)[0]


def _placed(strands: Strands, given: GroomFile) -> Strands:
    """Strands in metres, where the scene wants them."""
    low, high = strands.points.min(axis=0).astype(np.float64), strands.points.max(axis=0).astype(np.float64)
    factor = given.scale
    if given.size is not None:
        factor = given.size / float((high - low).max())
    if factor != 1:
        strands, _ = scaled(strands, factor)
    if given.place == "file":
        return strands
    middle = 0.5 * factor * (low + high)
    if given.place == "ground":
        middle[1] = factor * low[1]
    moved = np.empty_like(strands.points)
    for begin in range(0, moved.shape[0], CHUNK):
        moved[begin : begin + CHUNK] = strands.points[begin : begin + CHUNK] - middle
    return replace(strands, points=moved)


def _units(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vectors (k, 3); +y where there is no direction."""
    sizes = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(sizes > 0, vectors / np.where(sizes > 0, sizes, 1.0), np.array([0.0, 1.0, 0.0]))
