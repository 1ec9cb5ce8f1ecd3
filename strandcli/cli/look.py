"""Looking at a run while it goes on: frames in the terminal, and SIGUSR1, on which the newest frame is written."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import StrandError
from .progress import Progress
from .terminal_pictures import Preview

if TYPE_CHECKING:
    from ..output.frames import FrameWriter
    from ..run.frame import Frame

NOW = "now.png"
PAUSE = 1.0
"""Seconds between two pictures in the terminal at least."""


class Look:
    """What is seen of a run that draws into a folder."""

    def __init__(self, preview: Preview, directory: Path) -> None:
        self._preview, self._path = preview, directory / NOW
        self._newest: tuple[int, Any] | None = None
        self._shown = -PAUSE
        self._asked = threading.Event()
        self._ended = False

    def hand_on(self, writer: FrameWriter, frame: Frame) -> None:
        """A frame is done: hand it to what writes it, and show it."""
        assert frame.image is not None
        writer.submit(frame.number, frame.image, frame.aovs)
        self.seen(frame.number, frame.image)

    def seen(self, number: int, image: Any) -> None:
        """A frame is done: (H, W, 3), which the caller may reuse."""
        import numpy as np

        self._newest = number, np.array(image)
        now = time.monotonic()
        if now - self._shown >= PAUSE:
            self._shown = now
            self._preview.show(image)

    @contextmanager
    def signalled(self, progress: Progress) -> Iterator[None]:
        """A block in which SIGUSR1 has the newest frame written and told, or the first as soon as it is done."""
        number = getattr(signal, "SIGUSR1", None)
        if number is None or threading.current_thread() is not threading.main_thread():
            yield
            return
        # the handler only sets a mark: it may run amid anything, a line that is being printed too
        before = signal.signal(number, lambda *_: self._asked.set())
        thread = threading.Thread(target=self._answer, args=(progress,), name="SIGUSR1", daemon=True)
        thread.start()
        try:
            yield
        finally:
            self._ended = True
            self._asked.set()
            thread.join()
            signal.signal(number, before)

    def _answer(self, progress: Progress) -> None:
        while True:
            self._asked.wait()
            while self._newest is None and not self._ended:
                time.sleep(0.02)
            self._asked.clear()
            if self._ended:
                return
            self._write(progress)

    def _write(self, progress: Progress) -> None:
        from ..output.files import write_pieces
        from ..output.png import encode

        assert self._newest is not None
        number, image = self._newest
        try:
            write_pieces(self._path, encode(image, {"Software": "strandcli"}))
            progress.line(f"{self._path}: frame {number}, {progress.done} of {progress.total} are done")
        except StrandError as error:  # what the run does is more important
            progress.line(str(error))
