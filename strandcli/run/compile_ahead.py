"""On an empty cache, worker processes compile a scene's kernels from the frame's end while the frame is begun.

Half of the first frame's wait is for kernels that it needs last. Those that another process is compiling are waited
for and loaded (see `strandcli.compiling`). Whatever goes wrong here costs time, nothing else.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..common.limits import cores
from ..compiling.service import service

if TYPE_CHECKING:
    from ..scene.model import Scene

PARTS = ("light", "coverage")
"""Of a frame, from its end."""


def begin(scene: Scene, threads: int | None) -> None:
    """Have the workers start when a kernel turns out to be missing; ``threads``: processes that may be busy at once,
    None for as many as there are cores."""
    service.ahead(scene, PARTS, cores() if threads is None else threads)


def end() -> None:
    """End what is still compiled ahead."""
    service.stop_ahead()


def compile_parts(scene: Scene, parts: Sequence[str]) -> None:
    """Compile the kernels of some of `PARTS`, in a worker."""
    from ..draw.compile_parts import compile_part
    from ..draw.renderer import Renderer
    from ..groom.emit import emit

    small = dataclasses.replace(scene, image=dataclasses.replace(scene.image, size=(8, 8)))
    renderer = Renderer(small, emit(scene.emitter, scene.seed, 1))
    for part in parts:
        compile_part(renderer, part)
