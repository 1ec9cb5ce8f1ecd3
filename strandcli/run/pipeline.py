"""From a scene to frames: emit once, then for each frame simulate and draw."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, TypeVar

from ..compiling import runtime
from ..compiling.clock import clock
from ..compiling.folder import cache
from ..compiling.service import service
from ..errors import UsageError
from ..plan import pictures_that_fit
from ..scene.model import Scene
from ..scene.named_files import naming_files
from .frame import Frame, FrameRenderer
from .ordered_map import ordered_map, worker_count
from .stages import MovedStrands, Notify, Positions, RunOptions, SimulationStage

if TYPE_CHECKING:
    from .checkpoints import Checkpoints

Item = TypeVar("Item")

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
    checkpoints: Checkpoints | None = None,
) -> Iterator[Frame]:
    """Frames of a scene in ascending order (all of them by default); those before the first are simulated unseen.

    ``positions`` hands in what was simulated before, by frame number. Raises `SimulationError` at the first frame that
    has gone wrong (see `simulate.health`), drawn or not, and `UsageError` for a number of threads that the machine does
    not have. With ``keep_going`` the trouble is reported to ``warn`` once, and strands that cannot be drawn are left
    out. ``warn`` also hears what is hardly meant before the first frame (see `simulate.advice`). With ``checkpoints``
    the simulation goes on from the nearest one. Between two frames the caller's number of threads is as it was.
    """
    options = RunOptions(draw, keep_positions, keep_going, notify, warn, checkpoints)
    count = runtime.checked_threads(threads)
    runtime.tell(notify, warn)
    clock.expect(scene.source)
    if scene.panels and any(panel.image.aovs for panel in scene.panels):
        raise UsageError("image.aovs: a preset of several panels has no layers; draw one without panels")
    if any(one.emitter.groom is not None for one in scene.panels or (scene,)):
        from ..groom_file import completed

        scene = completed(scene)
    wanted = sorted(set(frames if frames is not None else range(1, scene.time.frames + 1)))
    with naming_files(scene):
        yield from _with_threads(count, _rendered(scene, wanted, positions, options))


def _with_threads(count: int, items: Iterator[Item]) -> Iterator[Item]:
    """``items``, each made with a number of threads that is the caller's own again when it is handed on."""
    try:
        while True:
            with runtime.thread_count(count):
                try:
                    item = next(items)
                except StopIteration:
                    return
            yield item
    finally:
        items.close()  # type: ignore[attr-defined]


def _rendered(scene: Scene, frames: Sequence[int], given: Positions | None, options: RunOptions) -> Iterator[Frame]:
    if options.warn is not None and (trouble := cache.keeps_nothing):
        options.warn(trouble)
    if not scene.panels:
        yield from _run(scene, frames, given, options)
        return
    from .panels import side_by_side

    parts = [
        _run(panel, frames, given, options.of_panel(number), several=False)
        for number, panel in enumerate(scene.panels, 1)
    ]
    yield from side_by_side(scene, parts)


def _run(
    scene: Scene, frames: Sequence[int], given: Positions | None, options: RunOptions, several: bool = True
) -> Iterator[Frame]:
    """Frames of a scene without panels; ``several``: more than one may be drawn at once."""
    import numba

    ahead = options.draw and bool(frames)
    if ahead:
        service.ahead(scene, numba.get_num_threads())
    try:
        moved = SimulationStage(scene, frames, given, options)
        notify = options.notify
        if notify is not None and given is None and (scene.time.preroll > 0 or (frames and frames[0] > 1)):
            notify(f"simulating up to frame {frames[0]}")
        if options.draw:
            for frame in _drawn(moved, frames, several):
                moved.warn_of_stretch(frame)
                yield frame
        else:
            for number in frames:
                yield moved.begin(number).frame
    finally:
        if ahead:
            service.stop_ahead()


def _drawn(moved: SimulationStage, frames: Sequence[int], several: bool) -> Iterator[Frame]:
    renderer, rest = FrameRenderer(moved), list(frames)
    simulate = draw = 0.0
    # all threads on one frame: the first compiles or loads kernels, the second tells what a frame costs
    for alone in frames[:2]:
        if moved.options.notify is not None:
            moved.options.notify(f"drawing frame {alone}")
        waited = runtime.compile_seconds()
        frame = renderer(moved.begin(alone))
        simulate, draw = _seconds(frame)
        draw -= runtime.compile_seconds() - waited
        rest.pop(0)
        yield frame
    at_once = _frames_at_once(moved.scene, rest, simulate, draw) if several and rest else 1
    if at_once > 1 and not runtime.entered_by_several():
        at_once = 1
        if moved.options.notify is not None:
            moved.options.notify(ONE_BY_ONE)
    if at_once > 1:
        yield from _drawn_at_once(moved, rest, renderer, at_once)
        return
    for number in rest:
        yield renderer(moved.begin(number))


def _drawn_at_once(
    moved: SimulationStage, frames: Sequence[int], renderer: FrameRenderer, at_once: int
) -> Iterator[Frame]:
    """Yield frames of which so many are drawn at once."""
    import numba

    moved.snapshots = True
    threads = numba.get_num_threads()
    last = frames[len(frames) - len(frames) % at_once :]
    """Fewer than there are workers, that share all threads."""

    def drawing(renderer: FrameRenderer) -> Callable[[MovedStrands], Frame]:
        def draw(job: MovedStrands) -> Frame:
            if job.frame.number in last:
                numba.set_num_threads(threads // len(last))
            return renderer(job)

        return draw

    workers = [drawing(one) for one in (renderer, *(FrameRenderer(moved) for _ in range(at_once - 1)))]
    yield from ordered_map(frames, moved.begin, workers, start=lambda: numba.set_num_threads(threads // at_once))


def _frames_at_once(scene: Scene, frames: Sequence[int], simulate: float, draw: float) -> int:
    """Return how many of these frames to draw at once, one of which takes so many seconds on all threads."""
    import numba

    return worker_count(numba.get_num_threads(), len(frames), simulate, draw, pictures_that_fit(scene, frames))


def _seconds(frame: Frame) -> tuple[float, float]:
    """Return the seconds of a frame's simulation, and of all else."""
    seconds = frame.report["seconds"]
    return seconds["simulate"] or 0.0, sum(took for stage, took in seconds.items() if stage != "simulate")
