"""On an empty cache, a second process compiles the kernels of light while the first compiles those before them.

Numba compiles on one thread of a process, and half of the first frame's wait is for kernels that it needs last. They
reach the first process through the cache folder. Whatever goes wrong here costs time, nothing else.
"""

from __future__ import annotations

import dataclasses
import os
import pickle
import subprocess
import sys
from typing import Any

from . import runtime


class Rehearsal:
    """Begins at once where it helps; `wait` before the first light."""

    def __init__(self, scene: Any) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        if not _helps():
            return
        try:
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
                pickle.dump(scene, pipe)
        except (OSError, pickle.PicklingError, AttributeError, TypeError):
            self.stop()

    def wait(self) -> None:
        """Until the second process is done."""
        if self._process is not None:
            with runtime.counted_as_compiling("light, in a second process"):
                self._process.wait()
            self._process = None

    def stop(self) -> None:
        """Do without it."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None


def _helps() -> bool:
    """Whether there is a core for it, and nothing compiled yet that it would compile."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    folder = runtime.shared_folder()
    return cores > 1 and folder is not None and next(folder.rglob("shade_strands.strands-*.nbi"), None) is None


def main() -> None:
    """Compile what the scene on standard input needs for light."""
    scene = pickle.load(sys.stdin.buffer)
    from .draw.renderer import Renderer
    from .groom.emit import emit

    for one in scene.panels or (scene,):
        small = dataclasses.replace(one, image=dataclasses.replace(one.image, size=(8, 8)))
        Renderer(small, emit(one.emitter, one.seed, 1)).rehearse()


if __name__ == "__main__":
    main()
