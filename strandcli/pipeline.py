"""From a scene to frames: emit once, then for each frame simulate and draw."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import runtime
from .blocks import unpack
from .crew import in_order, share_out
from .errors import SimulationError
from .groom.emit import emit
from .plan import needed_strands, pictures_that_fit
from .rehearsal import Rehearsal
from .scene.model import Scene

Notify = Callable[[str], None]
Positions = Callable[[int], NDArray[np.float32]]


@dataclass
class Frame:
    """One finished frame."""

    number: int
    image: NDArray[np.uint8] | None
    """(height, width, 3) sRGB; None where nothing was drawn."""
    positions: NDArray[np.float32] | None
    """(strands, particles, 3) metres, where they were asked for."""
    report: dict[str, Any]
    """Seconds a stage, counts and errors, as in report.json."""


def render(
    scene: Scene,
    frames: Sequence[int] | None = None,
    *,
    threads: int | None = None,
    positions: Positions | None = None,
    draw: bool = True,
    keep_positions: bool = False,
    notify: Notify | None = None,
) -> Iterator[Frame]:
    """Frames of a scene in ascending order (all of them by default); those before the first are simulated unseen.

    ``positions`` hands in what was simulated before, by frame number. Raises `SimulationError` where a coordinate stops
    being finite, and `UsageError` for a number of threads that the machine does not have.
    """
    wanted = sorted(set(frames if frames is not None else range(1, scene.time.frames + 1)))
    runtime.start(threads, notify)
    if scene.panels:
        from .panels import side_by_side

        parts = [_run(panel, wanted, positions, draw, keep_positions, notify, several=False) for panel in scene.panels]
        yield from side_by_side(scene, parts)
        return
    yield from _run(scene, wanted, positions, draw, keep_positions, notify)


def _run(
    scene: Scene,
    frames: Sequence[int],
    given: Positions | None,
    draw: bool,
    keep_positions: bool,
    notify: Notify | None,
    several: bool = True,
) -> Iterator[Frame]:
    rehearsal = Rehearsal(scene) if draw and frames else None
    try:
        film = _Film(scene, frames, given, draw, keep_positions)
        yield from _frames(film, frames, draw, several, rehearsal, notify)
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

    if numba.threading_layer() == "workqueue":  # it cannot be entered from two threads
        return 1
    relay = seconds["simulate"] or 0.0
    rest = sum(took for stage, took in seconds.items() if stage != "simulate")
    return share_out(numba.get_num_threads(), len(frames), relay, rest, pictures_that_fit(scene, frames))


@dataclass
class _Begun:
    """A frame whose strands are where they belong, to be drawn."""

    frame: Frame
    positions: NDArray[np.float32]


class _Film:
    """The strands of a scene, moved from frame to frame."""

    def __init__(
        self, scene: Scene, frames: Sequence[int], given: Positions | None, draw: bool, keep_positions: bool
    ) -> None:
        from .simulate import solver_of

        self.scene = scene
        self.groom = emit(scene.emitter, scene.seed, needed_strands(scene, frames) if draw else None)
        self.solver = solver_of(scene)(scene, self.groom)
        self.given = given
        self.keep_positions = keep_positions
        self.snapshots = False
        """Whether strands move on while a frame is drawn."""

    def begin(self, number: int) -> _Begun:
        """Move on to a frame, and look at what came out."""
        solver = self.solver
        began = time.perf_counter()
        if self.given is None:
            solver.advance(number)
        else:
            solver.take(number, self.given(number))
        seconds = {"simulate": None if self.given is not None else time.perf_counter() - began}
        error = solver.errors(number)
        counts = {"strands": self.groom.strands, "particles": self.groom.strands * self.scene.emitter.particles}
        if error["nonfinite"]:
            raise SimulationError(_blame(self.scene, solver, number))
        kept = unpack(solver.positions[:, 1:], self.groom.strands) if self.keep_positions else None
        report = {"frame": number, "seconds": seconds, "counts": counts, "error": error}
        positions = solver.positions.copy() if self.snapshots else solver.positions
        return _Begun(Frame(number, None, kept, report), positions)

    def draughtsman(self, rehearsal: Rehearsal | None = None) -> _Draughtsman:
        """One that draws, with memory of its own."""
        return _Draughtsman(self, rehearsal)


class _Draughtsman:
    def __init__(self, film: _Film, rehearsal: Rehearsal | None) -> None:
        from .draw.renderer import Renderer

        self._film = film
        self._renderer = Renderer(film.scene, film.groom, rehearsal.wait if rehearsal is not None else lambda: None)

    def __call__(self, begun: _Begun) -> Frame:
        import numba

        film, frame = self._film, begun.frame
        at = (frame.number - 1) / film.scene.time.fps
        drawing = self._renderer.draw(begun.positions, film.solver.lengths, at, numba.get_num_threads())
        frame.image = drawing.image
        frame.report["threads"] = numba.get_num_threads()
        frame.report["seconds"] |= drawing.seconds
        frame.report["counts"] |= drawing.counts
        frame.report["error"]["curve_px_max"] = drawing.curve_px_max
        return frame


def _blame(scene: Scene, solver: Any, number: int) -> str:
    """Where the first coordinate is that is no longer finite, and what may help."""
    bad = np.argwhere(~np.isfinite(solver.particles()).all(-1))
    strand, particle = (int(index) for index in bad[0])
    rules = ", ".join(use.name for use in scene.rules)
    return (
        f"frame {number}: strand {strand}, particle {particle} is no longer finite under the rules {rules}: "
        "use more time.substeps, a smaller wind.strength or gravity.acceleration, or stiffness with clamp: true"
    )
