"""Pictures of one scene by several numbers of threads, in a process that has as many.

Numba settles how many threads there are when a process begins, and tests have one or two. So pictures are drawn by a
process of their own: it reads a scene a line, and answers with a line of hashes.
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from typing import Any, Self

THREADS = tuple(range(1, 1 + int(os.environ.get("STRANDCLI_TEST_THREADS", "3"))))
"""Three in CI; `make threads` takes four."""


class Drawer:
    """The process that draws; a context, at whose end it ends."""

    def __enter__(self) -> Self:
        env = os.environ | {"NUMBA_NUM_THREADS": str(max(THREADS))}
        self._process = subprocess.Popen(
            [sys.executable, __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=env
        )
        return self

    def __exit__(self, *error: object) -> None:
        self._process.communicate()

    def hashes(self, **job: Any) -> list[str]:
        """What `draw` finds with each number of threads."""
        self._process.stdin.write(json.dumps(job) + "\n")
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        assert line, "the process has ended: its error is above"
        return list(json.loads(line))


def draw(preset: str, overrides: list[str], settings: dict[str, Any], shadow_size: int | None, threads: int) -> str:
    """The hash of frame 1 of a preset, by name or path, with all its layers; ``shadow_size``: of all its maps."""
    import strandcli
    from strandcli.scene.model import Scene

    scene: Scene = strandcli.load(preset, overrides, settings)
    if shadow_size is not None:
        sizes = {f"lights.{i}.shadow.size": shadow_size for i in range(len(scene.lights))}
        scene = strandcli.load(preset, overrides, settings | sizes)
    (frame,) = strandcli.render(scene, [1], threads=threads)
    found = hashlib.sha256(frame.image.tobytes())
    for name in sorted(frame.aovs):
        found.update(frame.aovs[name].tobytes())
    return found.hexdigest()


if __name__ == "__main__":
    for line in sys.stdin:
        job = json.loads(line)
        print(json.dumps([draw(**job, threads=threads) for threads in THREADS]), flush=True)
