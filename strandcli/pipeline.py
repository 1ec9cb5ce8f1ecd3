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

        parts = [_run(panel, wanted, positions, draw, keep_positions, notify) for panel in scene.panels]
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
) -> Iterator[Frame]:
    import numba

    from .simulate import solver_of

    groom = emit(scene.emitter, scene.seed, needed_strands(scene, frames) if draw else None)
    solver = solver_of(scene)(scene, groom)
    renderer = None
    if draw:
        from .draw.renderer import Renderer

        renderer = Renderer(scene, groom)
    if notify is not None and given is None and (scene.time.preroll > 0 or (frames and frames[0] > 1)):
        notify(f"simulating up to frame {frames[0]}")
    for number in frames:
        began = time.perf_counter()
        if given is None:
            solver.advance(number)
        else:
            solver.take(number, given(number))
        seconds: dict[str, float | None] = {"simulate": None if given is not None else time.perf_counter() - began}
        error = solver.errors(number)
        counts = {"strands": groom.strands, "particles": groom.strands * scene.emitter.particles}
        if error["nonfinite"]:
            raise SimulationError(_blame(scene, solver, number))
        image = None
        if renderer is not None:
            at = (number - 1) / scene.time.fps
            drawing = renderer.draw(solver.positions, solver.lengths, at, numba.get_num_threads())
            image = drawing.image
            seconds |= drawing.seconds
            counts |= drawing.counts
            error["curve_px_max"] = drawing.curve_px_max
        report = {"frame": number, "seconds": seconds, "counts": counts, "error": error}
        kept = unpack(solver.positions[:, 1:], groom.strands) if keep_positions else None
        yield Frame(number, image, kept, report)


def _blame(scene: Scene, solver: Any, number: int) -> str:
    """Where the first coordinate is that is no longer finite, and what may help."""
    bad = np.argwhere(~np.isfinite(solver.particles()).all(-1))
    strand, particle = (int(index) for index in bad[0])
    rules = ", ".join(use.name for use in scene.rules)
    return (
        f"frame {number}: strand {strand}, particle {particle} is no longer finite under the rules {rules}: "
        "use more time.substeps, a smaller wind.strength or gravity.acceleration, or stiffness with clamp: true"
    )
