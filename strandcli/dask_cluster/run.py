"""Frames of a run, drawn by workers while the simulation goes on."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from time import monotonic
from typing import TYPE_CHECKING, Any
from uuid import uuid4

from ..errors import RefusedError, StrandError
from ..run.frame import Frame
from . import worker
from .worker import Job, Task

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..scene.model import Scene

AHEAD = 2
"""Frames a thread of the cluster that are handed out before the first of them is back."""
RETRIES = 2
"""Times that a frame is tried again where it failed for a reason that may pass."""
LOOK = 0.5
"""Seconds between two looks at whether the run was interrupted, and at how many threads the cluster has."""
ALONE = 60.0
"""Seconds that a cluster may be without workers."""


def tasks_of(scene: Scene, numbers: tuple[int, ...], moved: Iterator[Frame]) -> Iterator[Task]:
    """Tasks for some frames. ``moved``: of them, and where the shutter is open of those before, the positions."""
    before: tuple[int, NDArray[Any]] | None = None
    for frame in moved:
        assert frame.positions is not None
        if frame.number in numbers:
            positions = {frame.number: frame.positions}
            if before is not None and scene.camera.shutter > 0 and before[0] == frame.number - 1:
                positions[before[0]] = before[1]
            yield Task(frame.number, positions, frame.report)
        before = frame.number, frame.positions


def needed(scene: Scene, numbers: tuple[int, ...]) -> tuple[int, ...]:
    """The frames whose positions are needed to draw some."""
    if scene.camera.shutter == 0:
        return numbers
    return tuple(sorted({*numbers, *(number - 1 for number in numbers if number > 1)}))


def drawn(client: Any, job: Job, tasks: Iterator[Task], check: Callable[[], None]) -> Iterator[Frame]:
    """Frames as they are done, in any order; ``check`` raises where the run is to end.

    Raises what a worker found wrong, and `RefusedError` for a frame at which several workers died and where the cluster
    is lost.
    """
    from distributed import CancelledError
    from distributed.comm.core import CommClosedError

    pending: dict[Any, int] = {}
    crew = _Crew(client)
    more = True
    try:
        while more or pending:
            check()
            while more and len(pending) < AHEAD * crew.threads():
                task = next(tasks, None)
                more = task is not None
                if task is not None:
                    pending[_sent(client, job, task)] = task.number
            yield from _finished(pending)
    except (CommClosedError, CancelledError):
        raise RefusedError("--dask: the scheduler is lost; finished frames stay, and --resume continues") from None
    finally:
        with suppress(Exception):
            client.cancel(list(pending), force=True)


def _sent(client: Any, job: Job, task: Task) -> Any:
    """The future of a frame. The job goes with each: what one worker alone holds is lost with it."""
    return client.submit(worker.draw, job, task, key=f"frame-{task.number}-{uuid4().hex}", retries=RETRIES, pure=False)


def _finished(pending: dict[Any, int]) -> Iterator[Frame]:
    """Take out what is done, after waiting a little for the first."""
    from distributed import wait

    if pending:
        with suppress(TimeoutError):
            wait(list(pending), timeout=LOOK, return_when="FIRST_COMPLETED")
    for future in [one for one in pending if one.done()]:
        yield _result(future, pending.pop(future))


def _result(future: Any, number: int) -> Frame:
    from distributed import KilledWorker

    try:
        found = future.result()
    except KilledWorker as error:
        raise RefusedError(
            f"--dask: frame {number}: the last worker of several that died over it was {error.last_worker.address}, "
            "perhaps for want of memory: give it fewer workers, or a smaller --size"
        ) from None
    if isinstance(found, StrandError):
        raise found
    frame: Frame = found
    return frame


class _Crew:
    """The threads of a cluster, asked for now and then."""

    def __init__(self, client: Any) -> None:
        self._client, self._count, self._asked, self._seen = client, 1, 0.0, monotonic()

    def threads(self) -> int:
        """How many there are. Raises `RefusedError` where there have been none for long."""
        now = monotonic()
        if now - self._asked > LOOK:
            self._count, self._asked = sum(self._client.nthreads().values()), now
            if self._count:
                self._seen = now
            elif now - self._seen > ALONE:
                raise RefusedError("--dask: all workers are gone; finished frames stay, and --resume continues")
        return max(1, self._count)
