"""Several frames at once: a sequential stage (simulate), then a parallel one (draw) on a pool of threads.

A frame's kernels are many and short, and on two threads each waits for its slower half: frames side by side, one
thread each, keep every core busy.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

Item = TypeVar("Item")
Job = TypeVar("Job")
Result = TypeVar("Result")


def worker_count(threads: int, frames: int, sequential: float, parallel: float, fits: int) -> int:
    """How many frames to work on at once.

    ``sequential``, ``parallel``: seconds that a frame takes in the two stages, each on all threads; ``fits``: frames
    that memory has room for. While one frame is in the sequential stage the others are drawn, so there is no use in
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
    finishes the job. ``start`` is called on each worker's thread first. No more than two items a worker are begun
    ahead of the caller.

    Raises what ``begin`` or a worker raised, when that item's turn comes. Leaving early stops the threads.
    """
    state = _State(iter(items), begin, start)
    pool = [threading.Thread(target=state.work, args=(worker,), name="frames", daemon=True) for worker in workers]
    state.ahead = 2 * len(pool)
    for thread in pool:
        thread.start()
    try:
        while True:
            done, value = state.next()
            if done:
                return
            yield value
    finally:
        state.stop()
        for thread in pool:
            thread.join()


class _State:
    """What the threads of a pool share."""

    def __init__(self, items: Iterator[Any], begin: Callable[[Any], Any], start: Callable[[], None]) -> None:
        self._items = items
        self._begin = begin
        self._start = start
        self._turn = threading.Lock()
        self._news = threading.Condition()
        self._finished: dict[int, tuple[bool, Any]] = {}
        self._begun = 0
        self._given = 0
        self._end: int | None = None
        self.ahead = 1

    def work(self, worker: Callable[[Any], Any]) -> None:
        self._start()
        while True:
            with self._turn:
                with self._news:
                    self._news.wait_for(lambda: self._end is not None or self._begun < self._given + self.ahead)
                    if self._end is not None:
                        return
                index = self._begun
                try:
                    job = self._begin(next(self._items))
                except StopIteration:
                    self._close(index)
                    return
                except BaseException as error:
                    self._put(index, False, error)
                    self._close(index + 1)
                    return
                self._begun += 1
            try:
                self._put(index, True, worker(job))
            except BaseException as error:
                self._put(index, False, error)
                self._close(index + 1)
                return

    def next(self) -> tuple[bool, Any]:
        """Whether all is done, else the next result; raises where that is an error."""
        with self._news:
            self._news.wait_for(lambda: self._given in self._finished or self._given == self._end)
            if self._given not in self._finished:
                return True, None
            fine, value = self._finished.pop(self._given)
            self._given += 1
            self._news.notify_all()
        if not fine:
            raise value
        return False, value

    def stop(self) -> None:
        self._close(0)

    def _put(self, index: int, fine: bool, value: Any) -> None:
        with self._news:
            self._finished[index] = (fine, value)
            self._news.notify_all()

    def _close(self, end: int) -> None:
        """No item from ``end`` on is begun."""
        with self._news:
            self._end = end if self._end is None else min(self._end, end)
            self._news.notify_all()
