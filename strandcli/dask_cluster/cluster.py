"""A Dask cluster that runs somewhere, or workers of this machine that end with the run; and frames drawn by its workers
while the simulation goes on."""

from __future__ import annotations

import logging
import tempfile
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from time import monotonic
from typing import TYPE_CHECKING, Any
from uuid import uuid4

from ..common.counted import counted
from ..common.extras import install
from ..common.limits import cores
from ..errors import RefusedError, StrandError, UsageError
from ..plan import SHARE, available_memory, make_plan
from ..run import pipeline
from ..run.fingerprint import fingerprint
from ..run.frame import Frame
from ..scene.detail import with_before
from . import worker
from .worker import Job, Task, facts

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..scene.model import Scene

LOCAL = "local"
PATIENCE, WORKERS_PATIENCE = 10.0, 60.0
"""Seconds that a scheduler has to answer, and that a cluster may be without workers."""
AHEAD = 2
"""Frames a thread of the cluster that are handed out before the first of them is back."""
RETRIES = 2
"""Times that a frame is tried again where it failed for a reason that may pass."""
LOOK = 0.5
"""Seconds between two looks at whether the run was interrupted."""


def require_dask() -> None:
    """Raise `UsageError` where the package is missing."""
    try:
        import distributed  # noqa: F401
    except ImportError:
        raise UsageError(f"--dask: needs Dask's distributed: {install('dask')}") from None


@contextmanager
def connected(address: str, workers: int, warn: Callable[[str], None]) -> Iterator[Any]:
    """A block with a `distributed.Client` whose workers can draw. ``workers``: processes of `LOCAL`, a thread each.

    Raises `UsageError` for an address where no scheduler answers and for workers with another strandcli, and
    `RefusedError` where no worker comes. What may make last bits differ is reported to ``warn``.
    """
    require_dask()
    logger = logging.getLogger("distributed")
    before = logger.level
    with ExitStack() as stack:
        stack.callback(logger.setLevel, before)
        logger.setLevel(logging.CRITICAL + 1)  # the run tells of workers what matters
        stack.enter_context(warnings.catch_warnings())
        warnings.simplefilter("ignore")
        client = _local(workers, stack) if address == LOCAL else stack.enter_context(_remote(address))
        try:
            client.wait_for_workers(1, timeout=WORKERS_PATIENCE)
        except TimeoutError:
            raise RefusedError(
                f"--dask {address}: the scheduler has no workers; start some with 'dask worker {address}'"
            ) from None
        _compare(client, address, warn)
        yield client


def frames_of_cluster(
    scene: Scene, numbers: tuple[int, ...], *, address: str, positions: Any, threads: int | None,
    check: Callable[[], None], notify: Callable[[str], None], warn: Callable[[str], None], **settings: Any,
) -> Iterator[Frame]:  # fmt: skip
    """Frames as they are done. ``positions``: by frame number, or None where the scene is simulated here; ``threads``:
    processes of `LOCAL`, or threads of each worker elsewhere; ``settings``: of the simulation, as `pipeline.render` has
    them."""
    local = address == LOCAL
    free = available_memory()
    fitting = len(numbers) if free is None else int(SHARE * free) // make_plan(scene, numbers).memory_bytes - 1
    workers = min(threads or cores(), len(numbers), max(1, fitting))
    notify(f"starting {counted(workers, 'worker')}" if local else f"connecting to {address}")
    job = Job(scene, fingerprint(scene), numbers, settings["keep_going"], 1 if local else threads)
    frames = with_before(scene, numbers)
    moved: Iterator[Frame]
    if positions is not None:
        moved = (Frame(number, None, positions(number), {}) for number in frames)
    else:
        moved = pipeline.render(
            scene, frames, threads=threads, draw=False, keep_positions=True, notify=notify, warn=warn, **settings
        )
    with connected(address, workers, warn) as client:
        notify("")
        yield from drawn(client, job, tasks_of(scene, numbers, moved), check)


def _local(workers: int, stack: ExitStack) -> Any:
    from distributed import Client, LocalCluster

    folder = tempfile.TemporaryDirectory(prefix="strandcli-dask-", ignore_cleanup_errors=True)
    # the plan looks after memory: Dask's own limit is a share of the machine's, and kills workers that take more
    cluster = LocalCluster(
        n_workers=workers, threads_per_worker=1, processes=True, memory_limit=0, dashboard_address=None,
        local_directory=stack.enter_context(folder), silence_logs=logging.CRITICAL + 1,
    )  # fmt: skip
    return stack.enter_context(Client(stack.enter_context(cluster), timeout=WORKERS_PATIENCE))


def _remote(address: str) -> Any:
    from distributed import Client

    try:
        return Client(address, timeout=PATIENCE)
    except (OSError, ValueError, TypeError, ImportError) as error:
        why = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise UsageError(
            f"--dask {address}: no scheduler answers there ({why}): give its address as 'dask scheduler' prints it, "
            "such as tcp://HOST:8786, or --dask local"
        ) from None


def _compare(client: Any, address: str, warn: Callable[[str], None]) -> None:
    """Refuse workers whose frames would differ."""
    mine = facts()
    try:
        found = client.run(worker.facts, on_error="return")
    except Exception as error:  # what the scheduler or a worker could not make sense of
        raise UsageError(f"--dask {address}: workers do not understand this strandcli: {error}") from None
    for name, theirs in found.items():
        if not isinstance(theirs, dict):
            raise UsageError(
                f"--dask {address}: strandcli cannot be imported by worker {name} ({theirs}): install "
                f"strandcli {mine['strandcli']} there"
            )
        for part in (one for one in mine if theirs.get(one) != mine[one]):
            differ = f"worker {name} has {part} {theirs.get(part)}, and this machine {mine[part]}"
            if part == "strandcli":
                raise UsageError(f"--dask {address}: {differ}: install the same version everywhere")
            warn(f"--dask {address}: {differ}; last bits of pixels may differ")


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


def drawn(client: Any, job: Job, tasks: Iterator[Task], check: Callable[[], None]) -> Iterator[Frame]:
    """Frames as they are done, in any order; ``check`` raises where the run is to end.

    Raises what a worker found wrong, and `RefusedError` for a frame at which several workers died and where the cluster
    or all of its workers are lost.
    """
    from distributed import CancelledError, wait
    from distributed.comm.core import CommClosedError

    pending: dict[Any, int] = {}
    task, seen = next(tasks, None), monotonic()
    try:
        while task is not None or pending:
            check()
            threads = sum(client.nthreads().values())
            seen = monotonic() if threads else seen
            if monotonic() - seen > WORKERS_PATIENCE:
                raise RefusedError("--dask: all workers are gone; finished frames stay, and --resume continues")
            while task is not None and len(pending) < AHEAD * max(1, threads):
                # the job goes with each: what one worker alone holds is lost with it
                key = f"frame-{task.number}-{uuid4().hex}"
                pending[client.submit(worker.draw, job, task, key=key, retries=RETRIES, pure=False)] = task.number
                task = next(tasks, None)
            with suppress(TimeoutError):
                wait(list(pending), timeout=LOOK, return_when="FIRST_COMPLETED")
            for future in [one for one in pending if one.done()]:
                yield _result(future, pending.pop(future))
    except (CommClosedError, CancelledError):
        raise RefusedError("--dask: the scheduler is lost; finished frames stay, and --resume continues") from None
    finally:
        with suppress(Exception):
            client.cancel(list(pending), force=True)


def _result(future: Any, number: int) -> Frame:
    from distributed import KilledWorker

    try:
        found: Frame | StrandError = future.result()
    except KilledWorker as error:
        raise RefusedError(
            f"--dask: frame {number}: the last worker of several that died over it was {error.last_worker.address}, "
            "perhaps for want of memory: give it fewer workers, or a smaller --size"
        ) from None
    if isinstance(found, StrandError):
        raise found
    return found
