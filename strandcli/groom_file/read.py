"""The strands of a scene's file: read, mended, turned, scaled, placed, and packed for drawing."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..errors import UsageError
from ..exchange import faults
from ..exchange.change import strands_of
from ..exchange.control import note_of
from ..exchange.edit.fix import fixed, reversed_all
from ..exchange.edit.subsample import some
from ..exchange.edit.transform import turned
from ..exchange.files import ReadOptions, read
from ..exchange.strands import CACHED, Offsets, Strands
from ..groom.arrange import spatial_order
from ..groom.emit import stream
from ..groom.record import Groom
from ..inputs import cached
from .colours import colours_of
from .fits import hangs_from
from .measure import Seen, box_of, seen_of
from .on_solid import Head, anchors_on, head_of, put_on
from .rows import most_points, packed, with_at_most
from .widths import widths_of

if TYPE_CHECKING:
    from ..scene.model import GroomFile, Scene

UP = "y"
"""The up axis of scenes."""
TONES = 5
"""Number of the random stream of tones, as `strandcli.groom.emit` has it."""


ROUGHLY = 10_000
"""Strands, evenly chosen, that tell what all are like where that is enough."""


@dataclass(frozen=True, eq=False)
class FromFile:
    """The strands of a file in the emitter's frame."""

    strands: int
    groom: Groom
    """All of them, or some, without their points, where these are enough."""
    points: int
    """Of every strand, as it is drawn."""
    seen: Seen
    width: float | None
    """Metres, the mean of the file's own; None where it has none."""
    colour: tuple[float, float, float] | None
    """Linear, the mean of the file's own; None where it has none that is used."""
    notes: tuple[str, ...]
    """What a person should know of the file, a line each."""


def from_scene(scene: Scene, roughly: bool = False) -> FromFile:
    """The strands of a scene with ``emitter.groom``, as `from_file`; all of them where some are simulated."""
    assert scene.emitter.groom is not None
    return from_file(scene.emitter.groom, scene.seed, head_of(scene), roughly and not scene.guided)


def from_file(given: GroomFile, seed: int, head: Head | None = None, roughly: bool = False) -> FromFile:
    """The strands that a scene's ``emitter.groom`` asks for, on the solid that it names. Raises `UsageError`, one line,
    for a file that is damaged or cannot be drawn. The last one is kept as long as its files do not change.

    ``roughly``: all are read, counted and looked through for faults, but some of them tell what they look like. The
    notes are the same.
    """
    return _from_file(replace(given, cover=None), seed, head, roughly and head is None)  # which changes no strand


@cached(1)
def _from_file(given: GroomFile, seed: int, head: Head | None, roughly: bool) -> FromFile:
    notes: list[str] = []
    strands = _read(given, seed, notes)
    counts = strands.counts()
    step = strands.count // ROUGHLY if roughly else 1
    if step > 1 and most_points(counts) == counts.max():
        found = _made(strands.select(np.arange(strands.count) % step == 0), counts, given, seed, None, list(notes))
        if _tells_all(found, strands, given):
            return found
    return _made(strands, counts, given, seed, head, notes)


def _tells_all(found: FromFile, strands: Strands, given: GroomFile) -> bool:
    """Whether what was found of some strands holds of all: widths or colours that seem useless may be so of these
    alone, and notes have numbers of them."""
    used = {"width": found.width is not None, "colour": found.colour is not None or given.colours != "file"}
    own = {name for name, one in strands.attributes.items() if one.domain != "groom"}
    return all(used[name] for name in used.keys() & own)


def _made(
    strands: Strands, counts: Offsets, given: GroomFile, seed: int, head: Head | None, notes: list[str]
) -> FromFile:  # fmt: skip
    """Strands of a file, placed and packed; ``counts``: points of all strands (S,), of which these are some."""
    strands, up = _upright(strands, given, notes)
    strands, factor = _placed(strands, given)
    if head is not None:
        strands = put_on(strands, head, given.file, notes, up, given)
    roots, lengths = strands.roots(), strands.lengths()
    share = counts.size / strands.count
    widths = widths_of(strands, factor, lengths, share * float(lengths.sum()), notes)
    colours = colours_of(strands) if given.colours == "file" else None
    tones = (2.0 * stream(seed, TONES, strands.count) - 1.0).astype(np.float32)
    if colours is not None:
        tones = colours.tones
        notes.append(f"{given.file}: strands have the file's colours; emitter.groom.colours: none gives the material's")
    order = spatial_order(roots)
    most = most_points(counts)
    strands, fewer, off = with_at_most(strands, most)
    if fewer:
        notes.append(
            f"{given.file}: {strands_of(fewer)} of more than {most:,} points, up to {int(counts.max()):,}, drawn with "
            f"{most:,}, at most {off:.3g} m off: for memory all strands have as many"
        )
    if counts.min() < most:
        notes.append(
            f"{given.file}: strands have {counts.min():,} to {most:,} points; shorter ones get more on their segments"
        )
    seen = seen_of(strands, lengths)
    if seen.apart:
        notes.append(f"{given.file}: some strands lie far from all others; the picture is not fitted to them")
    seen = replace(seen, length=share * seen.length)
    points = packed(strands.first, strands.points, order, most) if share == 1 else None
    way = strands.points[strands.first[:-1] + 1].astype(np.float64) - roots
    groom = Groom(
        roots[order],
        _units(way)[order].astype(np.float32),
        lengths[order].astype(np.float32),
        tones[order],
        places=order,
        points=points,
        widths=None if widths is None or points is None else widths.packed(strands, factor, order, most),
        colours=None if colours is None else colours.palette,
        anchors=anchors_on(head, roots[order]),
    )
    width = None if widths is None else widths.mean
    return FromFile(counts.size, groom, most, seen, width, None if colours is None else colours.mean, tuple(notes))


def _read(given: GroomFile, seed: int, notes: list[str]) -> Strands:
    """The file's strands in its own frame, root to tip, without those that cannot be drawn."""
    path = Path(given.file)
    strands = read(path, ReadOptions(given.stride, given.array or None, given.fix, given.object))
    notes += [f"{path}: {strands_of(count)} of {why}, skipped" for why, count in strands.source.skipped.items()]
    curves = note_of(strands.source.facts)
    notes += [f"{path}: {curves}"] if curves else []
    if given.fix:
        before = strands
        strands, change = fixed(strands, given.root == "auto", "emitter.groom.root: first has none turned")
        if strands is not before:
            notes.append(f"{path}: {change.text}")
    if given.root == "last":
        strands, _ = reversed_all(strands)
    if given.strands is not None and given.strands < strands.count:
        strands, _ = some(strands, given.strands, seed)
    if not strands.count:
        raise UsageError(f"{path}: holds no strand that could be drawn")
    if given.fix:
        return strands
    bare = faults.without_length(strands)
    if bare.any():
        raise UsageError(
            f"{path}: {strands_of(int(bare.sum()))} without length (strand {int(np.argmax(bare)):,} for one); set "
            "emitter.groom.fix: true, which leaves them out"
        )
    return strands


def _upright(strands: Strands, given: GroomFile, notes: list[str]) -> tuple[Strands, str]:
    """Strands whose up axis is y, and the file's."""
    up = given.up
    if up == "auto":
        up = strands.source.up or UP
        guess = None if strands.source.up else hangs_from(strands)
        if guess is not None and guess != up:
            up = guess
            notes.append(f"{given.file}: up is taken to be {up}, which becomes y; emitter.groom.up says otherwise")
    return strands if up == UP else turned(strands, up, UP)[0], up


def _placed(strands: Strands, given: GroomFile) -> tuple[Strands, float]:
    """Strands in metres, where the scene wants them, and the metres of a unit of the file. Raises `UsageError` where
    single precision ends before that."""
    factor, middle = strands.source.unit or 1.0 if given.scale is None else given.scale, np.zeros(3)
    if given.size is not None or given.place != "file":
        low, high = box_of(strands.points)
        if given.size is not None:
            factor = given.size / float((high - low).max())
        if given.place != "file":
            middle = 0.5 * factor * (low + high)
            if given.place == "ground":
                middle[1] = factor * low[1]
    if factor == 1 and not middle.any():
        return strands, factor
    moved = np.empty_like(strands.points)
    wide = np.empty((CACHED, 3))
    with np.errstate(over="ignore"):
        for begin in range(0, moved.shape[0], CACHED):
            held = strands.points[begin : begin + CACHED]
            part = np.multiply(held, factor, out=wide[: held.shape[0]], dtype=np.float64)
            part -= middle
            moved[begin : begin + CACHED] = part
    if not np.isfinite(box_of(moved)).all():
        raise UsageError(f"{given.file}: points are too far out for single precision; set emitter.groom.scale or size")
    return replace(strands, points=moved), factor


def _units(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vectors (k, 3); +y where there is no direction."""
    sizes = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(sizes > 0, vectors / np.where(sizes > 0, sizes, 1.0), np.array([0.0, 1.0, 0.0]))
