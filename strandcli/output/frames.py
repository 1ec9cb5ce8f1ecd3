"""The frames of a run as files ``frame_0001.png`` …, encoded on a thread of their own while the next one is drawn."""

from __future__ import annotations

import os
import queue
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from ..errors import RefusedError, UsageError
from ..files.inputs import unrecorded
from . import png
from .claim import Claim
from .files import begin_pieces, prepare_folder, refuse_present, require_own, with_whole
from .layers import Layers, is_of, is_whole, layer_files, write_layers
from .room import frame_bytes

_TOGETHER = 8
"""Pictures that wait for the disk together, which takes 8 in two and a half times as long as one."""
_DISK_SECONDS = 0.25
"""How long the last of them waits for the next one."""
_PATIENCE = 0.1
"""Seconds that the thread that draws waits for room in the queue before it writes a picture itself."""


@dataclass(frozen=True, slots=True)
class Written:
    """One finished file. ``seconds`` is the time of hashing, encoding and writing; None for a frame that was kept."""

    frame: int
    file: str
    pixels_sha256: str
    seconds: float | None


def frame_file(frame: int) -> str:
    """The file name of a frame; four digits at least, so that names sort up to frame 9999."""
    return f"frame_{frame:04d}.png"


class FrameWriter:
    """Takes pictures and leaves finished PNG files in one folder.

    Everything that can be refused is refused by the constructor, before anything is computed. Use it as a context
    manager: leaving the block, for whatever reason, finishes the frames that were handed in and stops the thread.
    """

    def __init__(
        self,
        directory: Path,
        frames: Sequence[int],
        size: tuple[int, int],
        *,
        overwrite: bool = False,
        resume: bool = False,
        scene: str = "",
        also: Sequence[str] = (),
        own: Sequence[str] = (),
        layers: Sequence[str] = (),
        exr: bool = False,
    ) -> None:
        """``size`` is (width, height). ``scene`` is a fingerprint kept inside each file, so that ``resume`` can tell
        frames of another scene. ``also`` names further files that the run will write and must not find, ``own`` those
        which it will replace if they are strandcli's. ``layers`` are those that come with each picture, and ``exr``
        whether as EXR too (see `layers.write_layers`).

        Raises ``RefusedError`` for a folder that cannot be written to or has too little room, or where another run is
        writing the same frames, and ``UsageError`` for files that are in the way.
        """
        if overwrite and resume:
            raise UsageError("--overwrite and --resume exclude each other: replace the frames, or skip them")
        self.directory = directory
        self.size = size
        self.scene = scene
        self.layers = tuple(layers)
        self.exr = exr
        self.written: dict[int, Written] = {}
        self._failure: BaseException | None = None
        self._begun: list[Callable[[], None]] = []
        self._finishing = False
        """Whether the disk is waited for, which the thread that draws has to do, too."""
        self._lock = threading.Lock()  # of the list above, to which the thread that draws adds, too
        self._queue: queue.Queue[tuple[int, png.Pixels, Layers] | None] = queue.Queue(maxsize=2)
        self._thread: threading.Thread | None = None
        width, height = size
        if directory.is_dir():
            self._look(frames, overwrite, resume, also)
            for name in () if overwrite else own:
                require_own(directory / name)
        self.wanted = tuple(frame for frame in frames if frame not in self.written)
        prepare_folder(directory, len(self.wanted) * frame_bytes(width * height, self.layers, exr))
        self._claim = Claim(directory, "frames", self.wanted)

    def _look(self, frames: Sequence[int], overwrite: bool, resume: bool, also: Sequence[str]) -> None:
        there = [frame for frame in frames if (self.directory / frame_file(frame)).exists()]
        beside = [name for frame in frames for name in layer_files(frame, self.layers, self.exr)]
        others = [name for name in (*beside, *also) if (self.directory / name).exists()]
        if resume:
            for frame in there:
                self._keep(frame)
        elif not overwrite:
            refuse_present(self.directory, [frame_file(frame) for frame in there] + others)

    @unrecorded()
    def _keep(self, frame: int) -> None:
        """Keep a frame that is whole and of the right size; one that is neither will be drawn again."""
        path = self.directory / frame_file(frame)
        files = [self.directory / name for name in layer_files(frame, self.layers, self.exr)]
        if not all(is_whole(one, self.layers) for one in files):
            return
        try:
            image = png.load_frame(path, self.size)
        except UsageError:
            return
        if image is None or image.mode not in ("RGB", "RGBA"):
            return
        others = [] if image.info.get(png.SCENE, "") == self.scene else [path]
        others += [one for one in files if not is_of(one, self.scene)]
        if others and self.scene:
            raise UsageError(
                f"{others[0]}: was made from another scene or with other settings, so --resume would mix two films; "
                f"empty {self.directory}, add --overwrite instead, or choose another folder with -o"
            )
        self.written[frame] = Written(frame, path.name, png.pixels_sha256(np.asarray(image)), None)

    def __enter__(self) -> Self:
        self._thread = threading.Thread(target=self._work, name="frame writer", daemon=True)
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._thread is not None:
            while self._help():
                pass
            self._put(None)
            self._thread.join()
            self._thread = None
            self._finish()
        self._claim.release()
        if kind is None:
            self._raise()

    def submit(self, frame: int, image: png.Pixels, layers: Layers | None = None) -> None:
        """Hand in a picture: uint8, (height, width, 3), or 4 with alpha, which the caller may reuse at once, and its
        layers, which the caller may not. Waits while two are queued, and writes one itself where that takes long.

        Raises what went wrong with an earlier frame.
        """
        self._raise()
        if (image.shape[1], image.shape[0]) != self.size:
            raise ValueError(f"frame {frame} is {image.shape[1]}x{image.shape[0]}, not {self.size[0]}x{self.size[1]}")
        self._put((frame, np.array(image, copy=True), layers or {}))

    def _put(self, item: tuple[int, png.Pixels, Layers] | None) -> None:
        """Queue an item, but never wait for a thread that has died."""
        while self._thread is not None and self._thread.is_alive():
            with suppress(queue.Full):
                self._queue.put(item, timeout=_PATIENCE)
                return
            if not self._finishing:
                self._help()

    def _help(self) -> bool:
        """Write the picture that waits longest on the thread that calls, for the writer's own gets little time where
        other programs are busy; returns whether one waited."""
        with suppress(queue.Empty):
            item = self._queue.get_nowait()
            if item is not None and self._failure is None:
                try:
                    self._write(*item)
                except BaseException as error:
                    self._finish(error)
            return True
        return False

    def _raise(self) -> None:
        if self._failure is None:
            return
        if isinstance(self._failure, RefusedError):
            drawn = [self.directory / one.file for one in self.written.values() if one.seconds is not None]
            raise with_whole(self._failure, drawn)
        raise self._failure

    def _work(self) -> None:
        # Kernels run on every core and wait for their slowest thread: this one takes what they leave. Linux keeps a
        # priority for each thread. What it does not come to, the thread that draws does.
        with suppress(OSError, AttributeError):
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), 10)
        try:
            while (item := self._next()) is not None:
                self._write(*item)
            self._finish()
        except BaseException as error:
            self._finish(error)

    def _next(self) -> tuple[int, png.Pixels, Layers] | None:
        """The next item of the queue; None after a failure. Written pictures get their names when there are enough of
        them, or when none has come for a while, in which the disk takes them."""
        if 0 < len(self._begun) < _TOGETHER:
            with suppress(queue.Empty):
                return self._queue.get(timeout=_DISK_SECONDS)
        self._finish()
        return None if self._failure else self._queue.get()

    def _finish(self, failure: BaseException | None = None) -> None:
        """Give written pictures their names, and then tell of a failure. The others stay where the disk refuses
        one, which is a failure too."""
        with self._lock:
            begun, self._begun = self._begun, []
        self._finishing = True
        for finish in begun:
            try:
                finish()
            except BaseException as error:
                failure = failure or error
        self._finishing = False
        self._failure = self._failure or failure  # last: whoever sees it counts the frames that are whole

    def _write(self, frame: int, image: png.Pixels, layers: Layers) -> None:
        start = time.perf_counter()
        path = self.directory / frame_file(frame)
        text = {"Software": "strandcli"}
        if self.scene:
            text[png.SCENE] = self.scene
        digest = png.pixels_sha256(image)
        # before the picture, which is the sign that all is there
        write_layers(self.directory, frame, layers, self.exr, self.scene)
        name_it = begin_pieces(path, png.encode(image, text))
        seconds = time.perf_counter() - start

        def finish() -> None:
            begun = time.perf_counter()
            name_it()
            self.written[frame] = Written(frame, path.name, digest, seconds + time.perf_counter() - begun)

        with self._lock:
            self._begun.append(finish)
