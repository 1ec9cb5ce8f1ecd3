"""The option `--dask` of `strandcli render`: frames drawn by the workers of a Dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import click

from ..common.counted import counted
from ..errors import UsageError
from . import complete, options, signals

if TYPE_CHECKING:
    from ..run.frame import Frame
    from ..scene.model import Scene

option = options.together(
    options.alone("dask", "max_error"),
    click.option(
        "--dask", metavar="ADDRESS", shell_complete=complete.clusters,
        help="Let the workers of a Dask cluster draw: 'local', or a scheduler such as tcp://HOST:8786.",
    ),
)  # fmt: skip


def require(scene: Scene, address: str | None) -> None:
    """Raise `UsageError` where workers are asked for, and cannot draw a scene or be asked by this machine."""
    if address is None:
        return
    from ..dask_cluster.connect import require_dask

    if scene.panels:
        raise UsageError("--dask: a preset of several panels has several sets of positions; draw it without")
    if not address.strip():
        raise UsageError("--dask: the address is empty; write local, or a scheduler's address such as tcp://HOST:8786")
    require_dask()


def frames(
    scene: Scene, numbers: tuple[int, ...], address: str, positions: Any, threads: int | None,
    notify: Callable[[str], None], warn: Callable[[str], None], **settings: Any,
) -> Iterator[Frame]:  # fmt: skip
    """Frames as they are done. ``threads``: processes of `local`, or threads of each worker elsewhere; ``settings``: of
    the simulation (see `pipeline.render`)."""
    from ..dask_cluster import connect, run
    from ..dask_cluster.job import Job
    from ..run import pipeline
    from ..run.fingerprint import fingerprint
    from ..run.frame import Frame

    local = address == connect.LOCAL
    workers = min(threads or options.available_cores(), len(numbers), _fitting(scene, numbers))
    starting = f"starting {counted(workers, 'worker')}"
    notify(starting if local else f"connecting to {address}")
    job = Job(scene, fingerprint(scene), numbers, settings["keep_going"], 1 if local else threads)
    needed = run.needed(scene, numbers)
    moved: Iterator[Frame]
    if positions is not None:
        moved = (Frame(number, None, positions(number), {}) for number in needed)
    else:
        moved = pipeline.render(
            scene, needed, threads=threads, draw=False, keep_positions=True, notify=notify, warn=warn, **settings
        )
    with connect.connected(address, workers, warn) as client:
        notify("")
        yield from run.drawn(client, job, run.tasks_of(scene, numbers, moved), signals.check)


def _fitting(scene: Scene, numbers: tuple[int, ...]) -> int:
    """Return how many processes that draw this machine's memory has room for, one at the least."""
    from ..plan import SHARE, available_memory, make_plan

    free = available_memory()
    return len(numbers) if free is None else max(1, int(SHARE * free) // make_plan(scene, numbers).memory_bytes - 1)
