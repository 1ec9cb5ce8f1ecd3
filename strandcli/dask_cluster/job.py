"""What every worker is told of a run, and what it hands back."""

from __future__ import annotations

import platform
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .. import __version__

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ..scene.model import Scene

ALIKE = ("strandcli",)
"""Of `facts`, what workers and the process that asks must have in common."""
SHOULD = ("numba", "llvm", "numpy")
"""What they should: last bits of pixels may depend on it."""


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
        "python": platform.python_version(),
    }
