"""Several frames at once: a sequential stage (simulate), then a parallel one (draw) on a pool of threads.

A frame's kernels are many and short, and on two threads each waits for its slower half: frames side by side, one
thread each, keep every core busy.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from queue import SimpleQueue
from threading import Lock
from typing import TypeVar

Item = TypeVar("Item")
Job = TypeVar("Job")
Result = TypeVar("Result")


def worker_count(threads: int, frames: int, sequential: float, parallel: float, fits: int) -> int:
    """How many frames to work on at once.

    ``sequential``, ``parallel``: seconds that a frame takes in the two stages, each on all threads; ``fits``: frames
    that memory has room for. While one frame is in the sequential stage the rest are drawn, so there is no use in
    more than (sequential + parallel) / sequential of them.
    """
    useful = frames if sequential <= 0 else int((sequential + parallel) / sequential)
    return max(min(threads, frames, useful, fits), 1)


def ordered_map(
    items: Iterable[Item],
    begin: Callable[[Item], Job],
    workers: Iterable[Callable[[Job], Result]],
    start: Callable[[], None] = lambda: None,
) -> Iterator[Result]:
    """Results in the order of ``items``: ``begin`` sees them one after the other, then whichever worker is free
    finishes the job. ``start`` is called on each thread first. No more than two items a worker are begun ahead of the
    caller.

    Raises what ``begin`` or a worker raised, when that item's turn comes. Leaving early stops the threads.
    """
    free: SimpleQueue[Callable[[Job], Result]] = SimpleQueue()
    for worker in workers:
        free.put(worker)
    asked: SimpleQueue[tuple[Item, Future[Result]]] = SimpleQueue()
    count, waiting, failed, turn = free.qsize(), deque[Future[Result]](), list[bool](), Lock()

    def begun(item: Item) -> Job:
        if failed:  # nothing is begun after what went wrong
            raise CancelledError
        try:
            return begin(item)
        except BaseException:
            failed.append(True)
            raise

    def work() -> None:
        worker = free.get()
        try:
            with turn:  # who has a turn takes the next item, so that there are no more threads than workers
                item, result = asked.get()
                try:
                    job = begun(item)
                except BaseException as error:
                    result.set_exception(error)
                    return
            try:
                result.set_result(worker(job))
            except BaseException as error:
                result.set_exception(error)
        finally:
            free.put(worker)

    pool = ThreadPoolExecutor(count, "frames", initializer=start)
    try:
        for item in items:
            if len(waiting) == 2 * count:
                yield waiting.popleft().result()
            waiting.append(Future())
            asked.put((item, waiting[-1]))
            pool.submit(work)
        while waiting:
            yield waiting.popleft().result()
    finally:
        pool.shutdown(cancel_futures=True)
