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
from .errors import SimulationError
from .groom.emit import emit
from .plan import needed_strands
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
    runtime.start(threads, notify)
    if scene.panels:
        from .panels import side_by_side

        parts = [
            _run(panel, wanted, positions, draw, keep_positions, Conduct(keep_going, notify, warn))
            for panel in scene.panels
        ]
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
) -> Iterator[Frame]:
    import numba

    from .simulate import solver_of
    from .simulate.advice import warnings
    from .simulate.health import examine

    groom = emit(scene.emitter, scene.seed, needed_strands(scene, frames) if draw else None)
    solver = solver_of(scene)(scene, groom)
    renderer = None
    if draw:
        from .draw.renderer import Renderer

        renderer = Renderer(scene, groom)
    notify = conduct.notify
    if notify is not None and given is None and (scene.time.preroll > 0 or (frames and frames[0] > 1)):
        notify(f"simulating up to frame {frames[0]}")
    if given is None and conduct.warn is not None:
        for words in warnings(scene, groom):
            conduct.warn(f"{scene.label}: {words}" if scene.label else words)
    told = False
    done = 0
    for number in frames:
        spent = 0.0
        # frames that nobody asked for are looked at too: a run that has gone wrong stops there
        for passed in [number] if given is not None else range(done + 1, number + 1):
            began = time.perf_counter()
            if given is None:
                solver.advance(passed)
            else:
                solver.take(passed, given(passed))
            spent += time.perf_counter() - began
            error = solver.errors(passed)
            trouble = None if told else examine(solver, passed, error, simulated=given is None)
            if trouble is not None and not conduct.keep_going:
                raise SimulationError(f"{trouble.message}, or go on regardless (--keep-going)", trouble)
            if trouble is not None:
                told = True
                if conduct.warn is not None:
                    conduct.warn(f"{trouble.message}; going on")
        done = number
        seconds: dict[str, float | None] = {"simulate": None if given is not None else spent}
        counts = {"strands": groom.strands, "particles": groom.strands * scene.emitter.particles}
        image = None
        if renderer is not None:
            at = (number - 1) / scene.time.fps
            drawing = _draw(renderer, solver, groom, at, numba.get_num_threads(), told)
            image = drawing.image
            seconds |= drawing.seconds
            counts |= drawing.counts
            error["curve_px_max"] = drawing.curve_px_max
        report = {"frame": number, "seconds": seconds, "counts": counts, "error": error}
        kept = unpack(solver.positions[:, 1:], groom.strands) if keep_positions else None
        yield Frame(number, image, kept, report)


def _draw(renderer: Any, solver: Any, groom: Any, at: float, workers: int, wary: bool) -> Any:
    """The drawing of a frame; where the run has gone wrong before, of the strands alone that can be drawn."""
    if not wary:
        return renderer.draw(solver.positions, solver.lengths, at, workers)
    from .draw.detail import drawn_fraction
    from .simulate.health import drawable

    # level of detail draws the first so many of all strands: those of them that are left
    first = min(max(round(renderer.scene.emitter.strands * drawn_fraction(renderer.scene, at)[0]), 1), groom.strands)
    kept = np.flatnonzero(drawable(solver)[:first])
    if not len(kept):
        raise SimulationError("no strand is left that could be drawn; end the run before, or mend the preset")
    renderer.tones = groom.tones[kept]
    lengths = solver.lengths.reshape(-1)[kept]
    drawing = renderer.draw(pack(unpack(solver.positions, groom.strands)[kept]), lanes(lengths[:, None]), at, workers)
    drawing.counts["left_out"] = first - len(kept)
    return drawing
