"""A client of a Dask cluster: one that runs somewhere, or workers of this machine that end with the run."""

from __future__ import annotations

import logging
import tempfile
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

from ..common.extras import install
from ..errors import RefusedError, UsageError
from .worker import ALIKE, SHOULD, facts

LOCAL = "local"
PATIENCE = 10.0
"""Seconds that a scheduler has to answer."""
WORKERS_PATIENCE = 60.0
"""Seconds that the first worker has to come."""


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
    `RefusedError` where no worker comes. What may make last bits differ is told to ``warn``.
    """
    require_dask()
    with ExitStack() as stack:
        stack.enter_context(_hushed())
        client = stack.enter_context(_local(workers) if address == LOCAL else _remote(address))
        if not client.nthreads():
            _wait(client, address)
        _compare(client, address, warn)
        yield client


@contextmanager
def _hushed() -> Iterator[None]:
    """A block in which Dask's lines about workers that come and go are not printed: the run tells what matters."""
    logger = logging.getLogger("distributed")
    before = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            yield
        finally:
            logger.setLevel(before)


@contextmanager
def _local(workers: int) -> Iterator[Any]:
    from distributed import Client, LocalCluster

    # the plan looks after memory: Dask's own limit is a share of the machine's, and kills workers that take more
    with (
        tempfile.TemporaryDirectory(prefix="strandcli-dask-", ignore_cleanup_errors=True) as folder,
        LocalCluster(
            n_workers=workers, threads_per_worker=1, processes=True, memory_limit=0, dashboard_address=None,
            local_directory=folder, silence_logs=logging.CRITICAL + 1,
        ) as cluster,
        Client(cluster, timeout=WORKERS_PATIENCE) as client,
    ):  # fmt: skip
        yield client


@contextmanager
def _remote(address: str) -> Iterator[Any]:
    from distributed import Client

    try:
        client = Client(address, timeout=PATIENCE)
    except (OSError, ValueError, TypeError, ImportError) as error:
        why = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise UsageError(
            f"--dask {address}: no scheduler answers there ({why}): give its address as 'dask scheduler' prints it, "
            "such as tcp://HOST:8786, or --dask local"
        ) from None
    with client:
        yield client


def _wait(client: Any, address: str) -> None:
    try:
        client.wait_for_workers(1, timeout=WORKERS_PATIENCE)
    except TimeoutError:
        raise RefusedError(
            f"--dask {address}: the scheduler has no workers; start some with 'dask worker {address}'"
        ) from None


def facts_here() -> dict[str, str]:
    """Return what workers are compared with."""
    return facts()


def _compare(client: Any, address: str, warn: Callable[[str], None]) -> None:
    """Refuse workers whose frames would be others."""
    mine = facts_here()
    try:
        found = client.run(facts, on_error="return")
    except Exception as error:  # what the scheduler or a worker could not make sense of
        raise UsageError(f"--dask {address}: workers do not understand this strandcli: {error}") from None
    for worker, theirs in found.items():
        if not isinstance(theirs, dict):
            raise UsageError(
                f"--dask {address}: strandcli cannot be imported by worker {worker} ({theirs}): install "
                f"strandcli {mine['strandcli']} there"
            )
        for name in (*ALIKE, *SHOULD):
            if theirs.get(name) == mine[name]:
                continue
            differ = f"worker {worker} has {name} {theirs.get(name)}, and this machine {mine[name]}"
            if name in ALIKE:
                raise UsageError(f"--dask {address}: {differ}: install the same version everywhere")
            warn(f"--dask {address}: {differ}; last bits of pixels may differ")
