"""What runs on a worker. One frame is drawn at a time in a process, on as many threads as it was given."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .. import __version__
from ..errors import StrandError, UsageError
from ..run.frame import Frame

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ..scene.model import Scene

_turn = threading.Lock()
_drawn: dict[str, _Drawn] = {}
"""What this process has made of the last scene that it drew, by its fingerprint."""


def draw(job: Job, task: Task) -> Frame | StrandError:
    """Return a frame with its picture. What cannot be mended by trying again is returned, not raised: Dask tries again
    what raises."""
    with _turn:
        try:
            if job.fingerprint not in _drawn:
                _drawn.clear()
                _drawn[job.fingerprint] = _Drawn(job)
            return _drawn[job.fingerprint](task)
        except StrandError as error:
            return error


class _Drawn:
    """A scene's strands and renderer."""

    def __init__(self, job: Job) -> None:
        """Raises `UsageError` where the files that the scene names differ here."""
        from ..compiling import runtime
        from ..run.fingerprint import fingerprint
        from ..run.frame import FrameRenderer
        from ..run.stages import RunOptions, SimulationStage
        from ..scene.named_files import naming_files

        scene = job.scene
        if fingerprint(scene) != job.fingerprint:
            raise UsageError(
                "--dask: a worker's scene is not the one that was sent: files that the preset names are missing there "
                "or others, or its strandcli is changed; give all machines the same files at the same paths"
            )
        if scene.emitter.groom is not None:
            from ..groom_file import completed

            scene = completed(scene)
        self._threads = runtime.checked_threads(job.threads or _given_threads())
        self._files, self._positions = naming_files, dict[int, Any]()
        with runtime.thread_count(self._threads), naming_files(scene):
            options = RunOptions(keep_going=job.keep_going)
            self._moved = SimulationStage(scene, job.frames, lambda number: self._positions[number], options)
            self._renderer = FrameRenderer(self._moved)
        self._scene = scene

    def __call__(self, task: Task) -> Frame:
        """Draw a frame."""
        from ..compiling import runtime

        self._positions = task.positions
        with runtime.thread_count(self._threads), self._files(self._scene):
            frame = self._renderer(self._moved.begin(task.number))
        simulated = task.report.get("seconds", {}).get("simulate")
        frame.report["seconds"]["simulate"] = simulated
        frame.report["error"] |= task.report.get("error", {})
        return frame


def _given_threads() -> int:
    """Threads that Dask lets this worker run, and no more than the machine has."""
    import numba
    from distributed import get_worker

    most: int = numba.config.NUMBA_NUM_THREADS  # type: ignore[attr-defined]
    return max(1, min(int(get_worker().state.nthreads), most))


@dataclass(frozen=True)
class Job:
    """A run. Dask sends it once to each worker."""

    scene: Scene
    fingerprint: str
    """Of the scene and of the files that it names (see `output.report.fingerprint`)."""
    frames: tuple[int, ...]
    """All frames of the run."""
    keep_going: bool = False
    threads: int | None = None
    """Of a worker process; None: as many as Dask has given it."""


@dataclass(frozen=True)
class Task:
    """A frame to draw."""

    number: int
    positions: dict[int, NDArray[np.float32]]
    """(strands, particles, 3) metres, of the frame and, where the shutter is open, of the one before."""
    report: dict[str, Any]
    """What the simulation says of the frame: seconds, counts, errors."""


def facts() -> dict[str, str]:
    """Versions that pixels depend on, in this process."""
    import llvmlite
    import numba
    import numpy as np

    return {
        "strandcli": __version__,
        "numba": numba.__version__,
        "llvm": ".".join(str(part) for part in llvmlite.binding.llvm_version_info),
        "numpy": np.__version__,
    }
