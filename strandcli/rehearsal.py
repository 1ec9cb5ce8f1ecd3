"""On an empty cache, a second process compiles the kernels of light while the first compiles those before them.

Numba compiles on one thread of a process, and half of the first frame's wait is for kernels that it needs last. They
reach the first process through the cache folder. What comes before light, the coverage of sorted strands, is compiled
by the process that comes to it first: whoever removes a part's file takes the part, which only one can. Whatever goes
wrong here costs time, nothing else.
"""

from __future__ import annotations

import dataclasses
import os
import pickle
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from . import runtime

PARTS = ("light", "coverage")
"""In the second process's order, which is the frame's from its end."""


class Rehearsal:
    """Begins at once where it helps; `wait` before each part of a frame."""

    def __init__(self, scene: Any) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._folder: Path | None = None
        if not _helps():
            return
        try:
            self._folder = Path(tempfile.mkdtemp(prefix="strandcli-"))
            for part in PARTS:
                (self._folder / part).touch()
            process = subprocess.Popen(
                [sys.executable, "-m", __name__],
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C is for the one that was started by hand
            )
            self._process = process
            assert process.stdin is not None
            with process.stdin as pipe:
                pickle.dump((scene, self._folder), pipe)
        except (OSError, pickle.PicklingError, AttributeError, TypeError):
            self.stop()

    def wait(self, part: str) -> None:
        """Until the second process has compiled this one of `PARTS`, if it has begun to; otherwise it never will."""
        if self._process is None or self._folder is None or take(self._folder, part):
            return
        with runtime.counted_as_compiling(f"{part}, in a second process"):
            self._process.wait()
        self.stop()

    def stop(self) -> None:
        """Do without it."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = None


def take(folder: Path, part: str) -> bool:
    """Whether this process is the one to compile a part: the first that asks."""
    try:
        (folder / part).unlink()
    except OSError:
        return False
    return True


def _helps() -> bool:
    """Whether there is a core for it, and nothing compiled yet that it would compile."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    folder = runtime.shared_folder()
    return cores > 1 and folder is not None and next(folder.rglob("shade_strands.strands-*.kernel"), None) is None


def main() -> None:
    """Compile what the scene on standard input needs, part by part, of those that nobody has taken."""
    scene, folder = pickle.load(sys.stdin.buffer)
    from .draw.rehearse import rehearse
    from .draw.renderer import Renderer
    from .groom.emit import emit

    small = dataclasses.replace(scene, image=dataclasses.replace(scene.image, size=(8, 8)))
    renderer = Renderer(small, emit(scene.emitter, scene.seed, 1))
    for part in PARTS:
        if take(folder, part):
            rehearse(renderer, part)


if __name__ == "__main__":
    main()
