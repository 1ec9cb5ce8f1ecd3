"""The strands of a scene's file: read, mended, turned, scaled, placed, and packed for drawing."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..common.counted import counted
from ..common.rotations import turning
from ..errors import UsageError, about
from ..exchange.edits import Step, edited, fixed, reversed_all, without_length
from ..exchange.files import Moments, ReadOptions, read_first
from ..exchange.parts import moved
from ..exchange.resample import some
from ..exchange.splines import note_of
from ..exchange.strands import CHUNK, Offsets, Points, Strands
from ..files.inputs import cached
from ..groom.blocks import spatial_order
from ..groom.deforming import units
from ..groom.emit import tones_of
from ..groom.record import Groom
from ..mesh_file.read import UP, standing
from .colours import colours_of, widths_of
from .film import Edits, Film
from .fits import hangs_from
from .measure import Seen, box_of, seen_of
from .on_solid import Head, anchors_on, head_of, put_on
from .rows import (
    Rows,
    most_points,
    packed,
    points_in,
    rows_in,
    with_at_most,
)

if TYPE_CHECKING:
    from ..scene.model import GroomFile, Scene


class Placement(NamedTuple):
    """Where strands of a file are put: their up axis, metres a unit, and their shift then (3,), metres."""

    up: str
    factor: float
    shift: NDArray[np.float64]


def placement_of(strands: Strands, given: GroomFile, notes: list[str]) -> Placement:
    """Where a scene wants the strands of a file: its up axis is as the scene or the file says, or a guess."""
    up = given.up
    if up == "auto":
        up = strands.source.up or UP
        guess = None if strands.source.up else hangs_from(strands)
        if guess is not None and guess != up:
            up = guess
            notes.append(f"{given.file}: up is taken to be {up}, which becomes y; emitter.groom.up says otherwise")
    scale = strands.source.unit or 1.0 if given.scale is None else given.scale
    return Placement(up, *standing(box_of(strands.points), up, scale, given.size, given.place))


def put(points: Points, given: GroomFile, placement: Placement) -> Points:
    """Points (P, 3) of a file in metres, y up, where the scene wants them. Raises `UsageError` where single precision
    ends before that."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[3, :3] = placement.factor * turning(placement.up, UP).T, placement.shift
    if np.array_equal(matrix, np.eye(4)):
        return points
    points = moved(points, matrix)
    if not np.isfinite(box_of(points)).all():
        raise UsageError(f"{given.file}: points are too far out for single precision; set emitter.groom.scale or size")
    return points


@dataclass(frozen=True, eq=False)
class FromFile:
    """The strands of a file in the emitter's frame."""

    strands: int
    groom: Groom
    points: int
    """Of every strand, as it is drawn."""
    seen: Seen
    width: float | None
    """Metres, the mean of the file's own; None where it has none."""
    colour: tuple[float, float, float] | None
    """Linear, the mean of the file's own; None where it has none that is used."""
    notes: tuple[str, ...]
    """What a person should know of the file, a line each."""
    placement: Placement
    rows: Rows | None = None
    """Of its points, as of `rows_in`, where the file moves: those of all moments."""
    moments: Moments | None = None
    """Of a file that moves."""


def from_scene(scene: Scene) -> FromFile:
    """The strands of a scene with ``emitter.groom``, as `from_file`; all of them where some are simulated."""
    assert scene.emitter.groom is not None
    return from_file(scene.emitter.groom, scene.seed, head_of(scene))


def from_file(given: GroomFile, seed: int, head: Head | None = None) -> FromFile:
    """The strands that a scene's ``emitter.groom`` asks for, on the solid that it names. Raises `UsageError`, one line,
    for a file that is damaged or cannot be drawn. The last one is cached as long as its files do not change."""
    with about("strands", given.file):
        return _from_file(replace(given, cover=None), seed, head)  # which changes no strand


@cached(1)
def _from_file(given: GroomFile, seed: int, head: Head | None) -> FromFile:
    notes: list[str] = []
    options = ReadOptions(given.stride, given.array or None, given.fix, given.object)
    strands, moments = read_first(Path(given.file), options, given.start)
    in_file = None if moments is None else strands.counts()
    if moments is None and given.start is not None:
        notes.append(f"{given.file}: does not move, and has no emitter.groom.start")
    if moments is not None and head is not None:
        raise UsageError(
            f"{given.file}: strands that move by themselves are put on no solid: take out emitter.groom.on, or take "
            "one moment of them ('strandcli convert IN OUT --frames 1')"
        )
    strands, rows = _chosen(strands, given, seed, notes, moments is not None)
    if moments is None or rows is None or in_file is None:
        alone = [strands]
        del strands  # which are let go in there as soon as they are packed
        return replace(_made(alone.pop(), given, seed, head, notes), rows=None)
    found = _made(strands, given, seed, head, notes)
    film = _film(moments, in_file, rows, strands, given, seed, found)
    return replace(found, moments=moments, groom=replace(found.groom, film=film))


def _film(
    moments: Moments, in_file: Offsets, rows: Offsets, strands: Strands, given: GroomFile, seed: int, found: FromFile
) -> Film:  # fmt: skip
    """The moments of a file of which ``found`` is the first: all are edited and placed as this one. ``in_file``: points
    of each strand of the file; ``rows``: which of them are those of the ``strands`` that are drawn."""
    assert found.groom.places is not None
    first, order = strands.first, found.groom.places
    ends = rows[np.stack([first[:-1], first[:-1] + 1], axis=1).reshape(-1)]

    def again(points: Points) -> NDArray[np.float32]:
        moved, _ = with_at_most(Strands(first, put(points[rows], given, found.placement)), found.points)
        return packed(moved.first, moved.points, found.rows, order, found.points)

    def ends_again(points: Points) -> NDArray[np.float64]:
        return put(points[ends], given, found.placement).reshape(-1, 2, 3).astype(np.float64)

    def anew(strands: Strands) -> Groom:
        chosen, _ = _chosen(strands, given, seed, [])
        made = _made(chosen, given, seed, None, [], found.placement)
        widths = made.groom.widths
        if widths is not None and made.width and found.width:
            widths = widths._replace(scale=widths.scale * np.float32(made.width / found.width))
        return replace(made.groom, widths=widths)

    return Film(moments, given.start, in_file, Edits(again, ends_again, anew))


def _made(
    strands: Strands, given: GroomFile, seed: int, head: Head | None, notes: list[str],
    placement: Placement | None = None,
) -> FromFile:  # fmt: skip
    """Strands of a file, placed and packed; ``placement``: where strands of this file are put, if that is known."""
    count, counts = strands.count, strands.counts(np.int32)
    least, longest = int(counts.min()), int(counts.max())
    placement = placement or placement_of(strands, given, notes)
    strands = replace(strands, points=put(strands.points, given, placement))
    if head is not None:
        strands = put_on(strands, head, given.file, notes, placement.up, given)
    order = spatial_order(strands.roots())
    lengths = strands.lengths()
    widths = widths_of(strands, placement.factor, lengths, notes)
    most = most_points(strands)
    strands, off = with_at_most(strands, most)
    rows = rows_in(strands.first, strands.points, most)
    colours = colours_of(strands, rows, most) if given.colours == "file" else None
    if colours is not None:
        notes.append(f"{given.file}: strands have the file's colours; emitter.groom.colours: none gives the material's")
    if most < longest:
        notes.append(
            f"{given.file}: strands of up to {longest:,} points are drawn with {most:,} each, at most {off:.3g} m "
            "off: for memory all have as many"
        )
    elif least < most:
        notes.append(
            f"{given.file}: strands have {least:,} to {most:,} points; shorter ones get more on their segments"
        )
    seen = seen_of(strands, lengths)
    if seen.apart:
        notes.append(f"{given.file}: some strands lie far from the rest; the picture is not fitted to them")
    lengths = lengths.astype(np.float32)[order]
    seconds = 1 if rows is None else rows[strands.first[order] + 1]
    packed_widths = None if widths is None else widths.packed(strands, placement.factor, rows, order, most)
    points = packed(strands.first, strands.points, rows, order, most)
    del strands  # all else follows from what is packed
    tones = (tones_of(seed, order.size) if colours is None else colours.tones)[order]
    roots = points_in(points, order.size, 0)
    groom = Groom(
        roots,
        _directions(roots, points_in(points, order.size, seconds)),
        lengths,
        tones,
        places=order,
        points=points,
        widths=packed_widths,
        colours=None if colours is None else colours.palette,
        anchors=anchors_on(head, roots),
    )
    width = None if widths is None else widths.mean
    colour = None if colours is None else colours.mean
    return FromFile(count, groom, most, seen, width, colour, tuple(notes), placement, rows)


def _directions(roots: Points, seconds: Points) -> Points:
    """Unit vectors (S, 3) from the roots (S, 3) of strands to their next points, whose place they take."""
    for begin in range(0, roots.shape[0], CHUNK):
        part = seconds[begin : begin + CHUNK]
        part[:] = units(part.astype(np.float64) - roots[begin : begin + CHUNK])
    return seconds


def _chosen(
    strands: Strands, given: GroomFile, seed: int, notes: list[str], moving: bool = False
) -> tuple[Strands, Offsets | None]:  # fmt: skip
    """The file's strands in its own frame, root to tip, without those that cannot be drawn; and where they are
    ``moving`` which points of the file (P,) they have."""
    path = Path(given.file)
    notes += [f"{path}: {counted(count, 'strand')} of {why}, skipped" for why, count in strands.source.skipped.items()]
    beside = strands.source.facts.get("not_read")
    if beside:
        there = ", ".join(f"{what} ({count:,})" for what, count in beside.items())
        notes.append(f"{path}: not read, beside its strands: {there}")
    changing = strands.source.facts.get("changing")
    if changing:
        notes.append(f"{path}: {', '.join(changing)} change with time; those of the first moment are drawn")
    curves = note_of(strands.source.facts)
    notes += [f"{path}: {curves}"] if curves else []
    steps = []
    if given.fix:
        fault = "emitter.groom.root: first has none turned"
        steps.append(Step(lambda strands: fixed(strands, given.root == "auto", fault), True))
    if given.root == "last":
        steps.append(Step(reversed_all, True))
    if given.strands is not None:
        wanted = given.strands
        steps.append(Step(lambda strands: some(strands, wanted, seed), True))
    count = strands.points.shape[0]
    strands, changes, replayed = edited(strands, steps, moving)
    notes += [f"{path}: {one.text}" for one in changes if one.edit == "fix" and any(one.facts.values())]
    if not strands.count:
        raise UsageError(f"{path}: has no strand that could be drawn")
    bare = None if given.fix else without_length(strands)
    if bare is not None and bare.any():
        raise UsageError(
            f"{path}: {counted(int(bare.sum()), 'strand')} without length (strand {int(np.argmax(bare)):,} for one); "
            "set emitter.groom.fix: true, which leaves them out"
        )
    return strands, None if replayed is None else replayed(np.arange(count))
