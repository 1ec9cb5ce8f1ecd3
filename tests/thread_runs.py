"""Pictures of one scene by several numbers of threads, in a process that has as many.

Numba settles how many threads there are when a process begins, and tests have one or two. So pictures are drawn by a
process of their own: it reads a scene a line, and answers with a line of hashes.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
from typing import Any

from answering import Answering

THREADS = tuple(range(1, 1 + int(os.environ.get("STRANDCLI_TEST_THREADS", "3"))))
"""Three in CI; `make threads` takes four."""


class Drawer(Answering):
    """The process that draws; a context."""

    def __init__(self) -> None:
        super().__init__(__file__, {"NUMBA_NUM_THREADS": str(max(THREADS))})

    def hashes(self, **job: Any) -> list[str]:
        """What `draw` finds with each number of threads."""
        return list(self.ask(job))


def draw(preset: str, overrides: list[str], settings: dict[str, Any], shadow_size: int | None, threads: int) -> str:
    """The hash of frame 1 of a preset, by name or path, with all its layers; ``shadow_size``: of all its maps."""
    import strandcli
    from strandcli.scene.model import Scene

    scene: Scene = strandcli.load(preset, overrides, settings)
    if shadow_size is not None:
        sizes = {f"lights.{i}.shadow.size": shadow_size for i in range(len(scene.lights))}
        scene = strandcli.load(preset, overrides, settings | sizes)
    (frame,) = strandcli.render(scene, [1], threads=threads)
    assert frame.image is not None
    found = hashlib.sha256(frame.image.tobytes())
    for name in sorted(frame.aovs):
        found.update(frame.aovs[name].tobytes())
    return found.hexdigest()


def main() -> None:
    """Answer every line of the standard input."""
    for line in sys.stdin:
        job = json.loads(line)
        print(json.dumps([draw(**job, threads=threads) for threads in THREADS]), flush=True)


if __name__ == "__main__":
    main()
