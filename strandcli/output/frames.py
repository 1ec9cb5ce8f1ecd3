"""The frames of a run as files ``frame_0001.png`` …, encoded on a thread of their own while the next one is drawn."""

from __future__ import annotations

import os
import threading
import time
from collections import deque
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
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
from .files import frame_bytes, prepare_folder, refuse_present, require_own, with_whole, write_pieces
from .layers import Layers, is_of, is_whole, layer_files, write_layers

QUEUED = 2
"""Pictures that wait for the thread that writes."""
NICENESS = 5
"""Of that thread, over that of threads that draw."""


@dataclass(frozen=True, slots=True)
class Written:
    """One finished file. ``seconds`` is the time of hashing, encoding and writing; None for earlier runs'."""

    frame: int
    file: str
    pixels_sha256: str
    seconds: float | None


def yield_to_kernels() -> None:
    """Have this thread take what kernels leave: they run on every core, and wait for their slowest thread. Linux keeps
    a priority for each thread. Beside other programs it still gets a quarter of a core."""
    with suppress(OSError, AttributeError):
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), NICENESS)


def frame_file(frame: int) -> str:
    """The file name of a frame; four digits at least, so that names sort up to frame 9999."""
    return f"frame_{frame:04d}.png"


class FrameWriter:
    """Takes pictures and leaves finished PNG files in one folder.

    Everything that can be refused is refused by the constructor, before anything is computed. Use it as a context
    manager: leaving the block, for whatever reason, finishes the frames that were handed in.
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
        """``size`` is (width, height). ``scene`` is a fingerprint stored in each file, so that ``resume`` can tell
        frames of another scene. ``also`` names further files that the run will write and must not find, ``own`` those
        which it will replace if they are strandcli's. ``layers`` are those that come with each picture, and ``exr``
        whether as EXR too (see `layers.write_layers`).

        Raises ``RefusedError`` for a folder that cannot be written to or has too little room, or where another run is
        writing the same frames, and ``UsageError`` for files that are in the way.
        """
        self.directory = directory
        self.size = size
        self.scene = scene
        self.layers = tuple(layers)
        self.exr = exr
        self.written: dict[int, Written] = {}
        self._waiting: deque[Future[None]] = deque()
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
        present = [name for name in (*beside, *also) if (self.directory / name).exists()]
        if resume:
            for frame in there:
                self._keep(frame)
        elif not overwrite:
            refuse_present(self.directory, [frame_file(frame) for frame in there] + present)

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
        foreign = [] if image.info.get(png.SCENE, "") == self.scene else [path]
        foreign += [one for one in files if not is_of(one, self.scene)]
        if foreign and self.scene:
            raise UsageError(
                f"{foreign[0]}: was made from another scene or with other settings, so --resume would mix two films; "
                f"empty {self.directory}, add --overwrite instead, or choose another folder with -o"
            )
        self.written[frame] = Written(frame, path.name, png.pixels_sha256(np.asarray(image)), None)

    def __enter__(self) -> Self:
        self._pool = ThreadPoolExecutor(1, "frame writer", yield_to_kernels)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._pool.shutdown()
        self._claim.release()
        if kind is None:
            self._wait(0)

    def submit(self, frame: int, image: png.Pixels, layers: Layers | None = None) -> None:
        """Hand in a picture: uint8, (height, width, 3), or 4 with alpha, which the caller may reuse at once, and its
        layers, which the caller may not. Waits while two are queued.

        Raises what went wrong with an earlier frame.
        """
        if (image.shape[1], image.shape[0]) != self.size:
            raise ValueError(f"frame {frame} is {image.shape[1]}x{image.shape[0]}, not {self.size[0]}x{self.size[1]}")
        self._wait(QUEUED)
        self._waiting.append(self._pool.submit(self._write, frame, np.array(image, copy=True), layers or {}))

    def _wait(self, most: int) -> None:
        """Wait until so many frames are not written yet; raises what went wrong with one that is done."""
        while self._waiting and (len(self._waiting) > most or self._waiting[0].done()):
            try:
                self._waiting.popleft().result()
            except RefusedError as error:
                drawn = [self.directory / one.file for one in self.written.values() if one.seconds is not None]
                raise with_whole(error, drawn) from error

    def _write(self, frame: int, image: png.Pixels, layers: Layers) -> None:
        start = time.perf_counter()
        path = self.directory / frame_file(frame)
        text = {"Software": "strandcli"}
        if self.scene:
            text[png.SCENE] = self.scene
        digest = png.pixels_sha256(image)
        # before the picture, which is the sign that all is there
        write_layers(self.directory, frame, layers, self.exr, self.scene)
        write_pieces(path, png.encode(image, text))
        self.written[frame] = Written(frame, path.name, digest, time.perf_counter() - start)
