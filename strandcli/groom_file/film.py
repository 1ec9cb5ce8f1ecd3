"""Strands of a file at any time of a film."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import RefusedError, UsageError
from ..exchange.files import Moments
from ..exchange.strands import CACHED, Offsets, Points, Strands
from ..groom.record import Groom

if TYPE_CHECKING:
    from ..scene.model import Scene

CACHED_MOMENTS = 2
"""Moments that are in memory."""
CACHED_ENDS = 12
"""Times of which first points are in memory: frames are drawn behind those that are simulated."""


class Shown(NamedTuple):
    """Strands at a time: points (blocks, n + 1, 3 W), metres, and the groom that they are of, which is the first
    moment's where the strands are the same."""

    points: NDArray[np.float32]
    groom: Groom


class Edits(NamedTuple):
    """What is done with strands of a file at a moment, decided at the first one."""

    packed: Callable[[Points], NDArray[np.float32]]
    """Of points (P, 3) of the file those that are drawn (blocks, n + 1, 3 W), metres."""
    ends: Callable[[Points], NDArray[np.float64]]
    """Of them the first two of each strand (S, 2, 3), metres."""
    anew: Callable[[Strands], Groom]
    """The groom of other strands."""


class Film:
    """The moments of a file, read as they are shown."""

    def __init__(self, moments: Moments, start: float | None, counts: Offsets, edits: Edits) -> None:
        """``start``: the clock at frame 1, None: its first; ``counts`` (S,): points of the strands of the file then."""
        self.moments, self.start = moments, start
        self._counts, self._edits = counts, edits
        self._read: dict[float, Strands] = {}
        self._ends: dict[float, NDArray[np.float64]] = {}
        self._lock = threading.Lock()

    def at(self, seconds: float, fps: float, first: Groom) -> Shown:
        """The strands so many seconds after frame 1 of a film of a rate; ``first``: those of frame 1. Between moments
        points move in straight lines, where strands are the same, unless the format says more."""
        moments = self.moments
        index, share = moments.around(moments.at(seconds, fps, self.start))
        if share == 0 and index == moments.around(moments.at(0.0, fps, self.start))[0]:
            assert first.points is not None
            return Shown(first.points, first)
        with self._lock:
            strands = self._strands(seconds, fps)
        if self._same(strands):
            return Shown(self._edits.packed(strands.points), first)
        groom = self._edits.anew(strands)
        assert groom.points is not None
        return Shown(groom.points, groom)

    def later(self) -> Iterator[NDArray[np.float32]]:
        """Points as of `Shown` at the middle and the last moment of those from frame 1 on, where they can be read; what
        is wrong with the rest is reported by frames that show them."""
        clock = self.moments.clock
        first, last = self.moments.around(self.moments.at(0.0, 1.0, self.start))[0], clock.size - 1
        for index in sorted({(first + last) // 2, last} - {first}):
            with suppress(UsageError, RefusedError):
                with self._lock:
                    strands = self._at(float(clock[index]))
                points = self._edits.packed(strands.points) if self._same(strands) else self._edits.anew(strands).points
                assert points is not None
                yield points

    def ends(self, seconds: float, fps: float) -> NDArray[np.float64]:
        """The first two points (S, 2, 3) of the strands then, metres. Raises `UsageError` where they are not those at
        first."""
        with self._lock:
            found = self._ends.get(seconds)
            if found is None:
                strands = self._strands(seconds, fps)
                if not self._same(strands):
                    raise UsageError(
                        f"{self.moments.path}: strands come and go, which simulated ones cannot; take out the rules "
                        "that move them, or take one moment ('strandcli convert IN OUT --frames 1')"
                    )
                found = self._edits.ends(strands.points)
                while len(self._ends) >= CACHED_ENDS:
                    del self._ends[next(iter(self._ends))]
                self._ends[seconds] = found
            return found

    def _same(self, strands: Strands) -> bool:
        return np.array_equal(strands.counts(), self._counts)

    def _strands(self, seconds: float, fps: float) -> Strands:
        """The strands of the file so many seconds after frame 1."""
        moments = self.moments
        value = moments.at(seconds, fps, self.start)
        moments.require(value)
        index, share = moments.around(value)
        if share == 0 or moments.interpolates:
            return self._at(float(moments.clock[index]) if share == 0 else value)
        return _mixed(self._at(float(moments.clock[index])), self._at(float(moments.clock[index + 1])), share)

    def _at(self, value: float) -> Strands:
        """The strands at a value of the clock."""
        found = self._read.pop(value, None)
        if found is None:
            while len(self._read) >= CACHED_MOMENTS:
                del self._read[next(iter(self._read))]
            found = self.moments.read(value)
            if self._same(found):
                found = replace(found, attributes={})
        self._read[value] = found
        return found


def _mixed(first: Strands, second: Strands, share: float) -> Strands:
    """Strands between two moments, or those of the first where these differ."""
    if not np.array_equal(first.counts(), second.counts()):
        return first
    points = np.empty_like(first.points)
    for begin in range(0, points.shape[0], CACHED):
        a, b = (one.points[begin : begin + CACHED].astype(np.float64) for one in (first, second))
        points[begin : begin + CACHED] = a + share * (b - a)
    return replace(first, points=points)


def notes_of(scene: Scene, moments: Moments | None, frames: Sequence[int] = ()) -> list[str]:
    """What is shown of a file that moves, where that is not all of it, a line each. Raises `UsageError` where a
    numbered file is missing that one of the ``frames`` shows."""
    if moments is None:
        return []
    given, time = scene.emitter.groom, scene.time
    assert given is not None
    needed = set(range(1, max(frames, default=0) + 1) if scene.guided else frames)
    if scene.camera.shutter > 0:
        needed |= {max(number - 1, 1) for number in frames}
    for number in sorted(needed):
        moments.require(moments.at(time.pose_time((number - 1) / time.fps), time.fps, given.start))
    path, has, found = given.file, moments.frames(time.fps, given.start), []
    if moments.files and given.start is None and min(moments.files) != 1:
        name = moments.files[min(moments.files)].name
        found.append(f"{path}: frame 1 shows {name}, the first there is; emitter.groom.start names another")
    if scene.guided and not any(use.name == "emitter_motion" for use in scene.rules):
        found.append(f"{path}: moves, but roots of simulated strands stand still: the rule emitter_motion moves them")
    elif time.frames < has:
        found.append(f"{path}: {has:,} frames have its {len(moments.clock):,} moments, {time.frames:,} are in the film "
                     "(time.frames)")  # fmt: skip
    elif time.frames > has and not time.loop:
        found.append(f"{path}: frames from {has + 1:,} on show its last moment, which is that of frame {has:,}")
    return found
