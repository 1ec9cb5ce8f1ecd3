"""From a scene to frames: emit once, then for each frame simulate and draw."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import runtime
from .blocks import lanes, pack, unpack
from .errors import SimulationError, UsageError
from .frame import Frame
from .groom.arrange import arranged
from .groom.children import Children
from .groom.combed import Combed
from .groom.emit import emit
from .ordered_map import in_order, share_out
from .plan import needed_strands, pictures_that_fit
from .rehearsal import Rehearsal
from .scene.model import Scene

Notify = Callable[[str], None]
Positions = Callable[[int], NDArray[np.float32]]

ONE_BY_ONE = (
    "frames are drawn one by one: with OpenMP (on Debian and Ubuntu the package libgomp1) several are drawn at once"
)
"""What ``notify`` hears where that would take less time."""


def render(
    scene: Scene,
    frames: Sequence[int] | None = None,
    *,
    threads: int | None = None,
    positions: Positions | None = None,
    draw: bool = True,
    keep_positions: bool = False,
    keep_going: bool = False,
    notify: Notify | None = None,
    warn: Notify | None = None,
) -> Iterator[Frame]:
    """Frames of a scene in ascending order (all of them by default); those before the first are simulated unseen.

    ``positions`` hands in what was simulated before, by frame number. Raises `SimulationError` at the first frame that
    has gone wrong (see `simulate.health`), drawn or not, and `UsageError` for a number of threads that the machine does
    not have. With ``keep_going`` the trouble is told to ``warn`` once, and strands that cannot be drawn are left out.
    ``warn`` also hears what is hardly meant before the first frame (see `simulate.advice`).
    """
    wanted = sorted(set(frames if frames is not None else range(1, scene.time.frames + 1)))
    if scene.panels and any(panel.image.aovs for panel in scene.panels):
        raise UsageError("image.aovs: a preset of several panels has no layers; draw one without panels")
    runtime.start(threads, notify)
    trouble = runtime.cache_trouble()
    if warn is not None and trouble is not None:
        warn(trouble)
    if scene.panels:
        from .panels import side_by_side

        conduct = Conduct(keep_going, notify, warn)
        parts = [_run(panel, wanted, positions, draw, keep_positions, conduct, several=False) for panel in scene.panels]
        yield from side_by_side(scene, parts)
        return
    yield from _run(scene, wanted, positions, draw, keep_positions, Conduct(keep_going, notify, warn))


@dataclass(frozen=True)
class Conduct:
    """What to do when a run goes wrong, and whom to tell."""

    keep_going: bool = False
    notify: Notify | None = None
    warn: Notify | None = None


def _run(
    scene: Scene,
    frames: Sequence[int],
    given: Positions | None,
    draw: bool,
    keep_positions: bool,
    conduct: Conduct,
    several: bool = True,
) -> Iterator[Frame]:
    rehearsal = Rehearsal(scene) if draw and frames else None
    try:
        film = _Film(scene, frames, given, draw, keep_positions, conduct)
        yield from _frames(film, frames, draw, several, rehearsal, conduct.notify)
    finally:
        if rehearsal is not None:
            rehearsal.stop()


def _frames(
    film: _Film,
    frames: Sequence[int],
    draw: bool,
    several: bool,
    rehearsal: Rehearsal | None,
    notify: Notify | None,
) -> Iterator[Frame]:
    import numba

    scene, given = film.scene, film.given
    if notify is not None and given is None and (scene.time.preroll > 0 or (frames and frames[0] > 1)):
        notify(f"simulating up to frame {frames[0]}")
    if not draw:
        for number in frames:
            yield film.begin(number).frame
        return
    # All threads on one frame: the first compiles or loads kernels, the second tells what a frame costs.
    draughtsman = film.draughtsman(rehearsal)
    seconds: dict[str, float] = {}
    for number in frames[:2]:
        frame = draughtsman(film.begin(number))
        seconds = frame.report["seconds"]
        yield frame
    rest = frames[2:]
    at_once = _frames_at_once(scene, rest, seconds) if several and rest else 1
    if at_once > 1 and not runtime.entered_by_several():
        at_once = 1
        if notify is not None:
            notify(ONE_BY_ONE)
    if at_once == 1:
        for number in rest:
            yield draughtsman(film.begin(number))
        return
    film.snapshots = True
    crew = [draughtsman, *(film.draughtsman() for _ in range(at_once - 1))]
    share = numba.get_num_threads() // at_once
    yield from in_order(rest, film.begin, crew, start=lambda: numba.set_num_threads(share))


def _frames_at_once(scene: Scene, frames: Sequence[int], seconds: dict[str, float]) -> int:
    import numba

    relay = seconds["simulate"] or 0.0
    rest = sum(took for stage, took in seconds.items() if stage != "simulate")
    return share_out(numba.get_num_threads(), len(frames), relay, rest, pictures_that_fit(scene, frames))


@dataclass
class _Begun:
    """A frame whose strands are where they belong, to be drawn."""

    frame: Frame
    positions: NDArray[np.float32]
    lengths: NDArray[np.float32]
    tones: NDArray[np.float32]
    before: NDArray[np.float32] | None
    """The strands a frame earlier, where the shutter is open."""
    ids: NDArray[np.int32] | None = None
    """Of each strand its place in the order of emission, where they do not stand in it."""


class _Film:
    """The strands of a scene, moved from frame to frame."""

    def __init__(
        self, scene: Scene, frames: Sequence[int], given: Positions | None, draw: bool, keep_positions: bool,
        conduct: Conduct,
    ) -> None:  # fmt: skip
        from .simulate import solver_of
        from .simulate.advice import warnings

        self.scene = scene
        self.groom = arranged(emit(scene.emitter, scene.seed, needed_strands(scene, frames) if draw else None))
        self.children = Children(scene, self.groom) if draw and scene.children is not None else None
        self.combed = None
        if draw and scene.emitter.tie is not None:
            self.combed = Combed(scene, self.groom if self.children is None else self.children.every)
        self.solver = solver_of(scene)(scene, self.groom)
        self.given = given
        self.draw = draw
        self.keep_positions = keep_positions
        self.conduct = conduct
        self._done = 0
        self._wrong = False
        if given is None:
            for words in [*warnings(scene, self.groom), *self.solver.warnings]:
                self._warn(f"{scene.label}: {words}" if scene.label else words)
        self.snapshots = False
        """Whether strands move on while a frame is drawn."""

    def begin(self, number: int) -> _Begun:
        """Move on to a frame, and look at what came out."""
        solver = self.solver
        before = None
        seconds: dict[str, float | None] = {"simulate": None if self.given is not None else 0.0}
        # frames that nobody asked for are looked at too: a run that has gone wrong stops there
        for passed in [number] if self.given is not None else range(self._done + 1, number + 1):
            began = time.perf_counter()
            if self.draw and self.scene.camera.shutter > 0 and passed == number > 1:
                if self.given is None:
                    solver.advance(number - 1)
                else:
                    solver.take(number - 1, self.given(number - 1))
                before = solver.positions.copy()
            if self.given is None:
                solver.advance(passed)
                seconds["simulate"] = (seconds["simulate"] or 0.0) + time.perf_counter() - began
            else:
                solver.take(passed, self.given(passed))
            error = solver.errors(passed)
            self._examine(passed, error)
        self._done = number
        counts = {"strands": self.groom.strands, "particles": self.groom.strands * self.scene.emitter.particles}
        kept = solver.particles() if self.keep_positions else None
        frame = Frame(number, None, kept, {"frame": number, "seconds": seconds, "counts": counts, "error": error})
        if self._wrong and self.draw:
            return self._sound(frame, before)
        positions = solver.positions.copy() if self.snapshots else solver.positions
        return _Begun(frame, positions, solver.lengths, self.groom.tones, before, self.groom.places)

    def _examine(self, number: int, error: dict[str, Any]) -> None:
        """Stop, or go on, where a frame with these errors has gone wrong."""
        from .simulate.health import examine

        if self._wrong:
            return
        trouble = examine(self.solver, number, error, simulated=self.given is None)
        if trouble is None:
            return
        if not self.conduct.keep_going:
            raise SimulationError(f"{trouble.message}, or go on regardless (--keep-going)", trouble)
        self._wrong = True
        self._warn(f"{trouble.message}; going on")

    def _warn(self, words: str) -> None:
        if self.conduct.warn is not None:
            self.conduct.warn(words)

    def _sound(self, frame: Frame, before: NDArray[np.float32] | None) -> _Begun:
        """The strands alone that can be drawn, of those that level of detail draws: so many that were emitted first."""
        from .draw.geometry.detail import needed
        from .simulate.health import drawable

        solver, groom, strands = self.solver, self.groom, self.groom.strands
        guiding = self.scene.children is not None
        first = strands if guiding else min(needed(self.scene, (frame.number - 1) / self.scene.time.fps), strands)
        fine = drawable(solver)
        fine[first:] = False
        kept = np.flatnonzero(groom.placed(fine))
        if not len(kept):
            raise SimulationError(f"frame {frame.number}: no strand is left that could be drawn; mend the preset")
        frame.report["counts"]["left_out"] = first - len(kept)
        if guiding:  # children leave out the strands that follow one that is no number
            marked = np.full((strands, solver.positions.shape[1], 3), np.nan, np.float32)
            marked[kept] = unpack(solver.positions, strands)[kept]
            return _Begun(frame, pack(marked), solver.lengths, groom.tones, None)
        positions = pack(unpack(solver.positions, strands)[kept])
        lengths = lanes(solver.lengths.reshape(-1)[kept, None])
        if before is not None:
            before = pack(unpack(before, strands)[kept])
            before = before if np.isfinite(before).all() else None
        ids = kept.astype(np.int32) if groom.places is None else groom.places[kept]
        return _Begun(frame, positions, lengths, groom.tones[kept], before, ids)

    def draughtsman(self, rehearsal: Rehearsal | None = None) -> _Draughtsman:
        """One that draws, with memory of its own."""
        return _Draughtsman(self, rehearsal)


class _Draughtsman:
    def __init__(self, film: _Film, rehearsal: Rehearsal | None) -> None:
        from .draw.renderer import Renderer

        self._film = film
        before = rehearsal.wait if rehearsal is not None else lambda part: None
        self._renderer = Renderer(film.scene, film.groom, before, film.children, film.combed)

    def __call__(self, begun: _Begun) -> Frame:
        import numba

        film, frame = self._film, begun.frame
        at = (frame.number - 1) / film.scene.time.fps
        self._renderer.tones = begun.tones
        self._renderer.ids = begun.ids
        drawing = self._renderer.draw(begun.positions, begun.lengths, at, numba.get_num_threads(), begun.before)
        frame.image = drawing.image
        frame.aovs = drawing.aovs
        frame.report["threads"] = numba.get_num_threads()
        frame.report["seconds"] |= drawing.seconds
        frame.report["counts"] |= drawing.counts
        frame.report["error"]["curve_px_max"] = drawing.curve_px_max
        return frame
