"""What is to be done, whatever scheduler runs it: a scene that stands by itself, and chunks of its frames."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ..plan import SHARE

SCENE, POSITIONS, FRAMES, CHUNKS = "scene.yaml", "positions", "frames", "chunks.txt"
"""Beside the job files: the preset with all settings, simulated positions, pictures, and a line a chunk."""
MOST_CHUNKS = 1000
"""Tasks of one job: Slurm takes 1,001 of an array as it comes, Open Job Description 1,024 of a step."""
USUAL_CHUNK = 8
"""Frames: a task starts in two seconds, which should be little beside its work."""
COMPILER = 700
"""MiB of a process that compiles: 530 were measured of `hair`."""


@dataclass(frozen=True, slots=True)
class Job:
    """A run in pieces. ``name``: the preset's, for people; ``chunks``: frames of each task, as ``-f`` takes them;
    ``simulated``: frames whose positions are needed, "" where nothing is simulated beforehand; ``threads`` and
    ``memory``, MiB: of a task; ``animate``: kinds of animation, "" for none; ``extra``: options of render that every
    task has."""

    name: str
    frames: str
    chunks: tuple[str, ...]
    simulated: str
    threads: int
    memory: int
    animate: str = ""
    extra: tuple[str, ...] = ()

    @property
    def warm_up_memory(self) -> int:
        """MiB of the task that compiles, a process a thread."""
        return max(self.memory, (self.threads + 1) * COMPILER)

    def warm_up(self, scene: str = SCENE) -> list[str]:
        """Arguments of strandcli that compile the kernels."""
        return ["warmup", scene, "--quiet"]

    def simulate(self, scene: str = SCENE, positions: str = POSITIONS) -> list[str]:
        """Those that simulate all that is drawn later."""
        return ["simulate", scene, "-o", positions, "-f", self.simulated, "--resume", "--no-progress"]

    def draw(self, chunk: str, scene: str = SCENE, positions: str = POSITIONS, frames: str = FRAMES) -> list[str]:
        """Those that draw a chunk."""
        cache = ["--from-cache", positions] if self.simulated else []
        return [
            "render",
            scene,
            *cache,
            "-o",
            frames,
            "-f",
            chunk,
            *self.extra,
            "--resume",
            "--no-html",
            "--no-progress",
        ]

    def join(self, scene: str = SCENE, positions: str = POSITIONS, frames: str = FRAMES) -> list[str]:
        """Those that look whether all frames are there, draw what is missing, and make animation and report."""
        cache = ["--from-cache", positions] if self.simulated else []
        animate = ["--animate", self.animate] if self.animate else []
        more = [*self.extra, *animate, "--resume", "--no-progress"]
        return ["render", scene, *cache, "-o", frames, "-f", self.frames, *more]


def asked_memory(planned: int) -> int:
    """MiB to ask a scheduler for, of the bytes that a plan tells within 15 %: so many that they are no more than the
    share of free memory that a run may take."""
    return math.ceil(1.15 * planned / SHARE / (1 << 20))


def chunks_of(frames: Sequence[int], size: int | None = None) -> tuple[str, ...]:
    """Ascending frames in chunks of ``size``, as ``-f`` takes them; by default of eight, more where there would be too
    many. Raises ``ValueError`` for too many chunks."""
    least = -(-len(frames) // MOST_CHUNKS)
    if size is not None and size < least:
        raise ValueError(
            f"--chunk {size}: makes {-(-len(frames) // size):,} tasks; at most {MOST_CHUNKS:,}: take {least}"
        )
    each = size or max(USUAL_CHUNK, least)
    return tuple(spelled(frames[i : i + each]) for i in range(0, len(frames), each))


def spelled(frames: Sequence[int]) -> str:
    """Ascending frames as ``-f`` takes them: ``1-8``, ``1-29x4``, ``1-3,9``."""
    parts: list[tuple[int, int, int]] = []  # first, last, step
    for frame in frames:
        if parts:
            first, last, step = parts[-1]
            if first == last or frame - last == step:
                parts[-1] = first, frame, frame - last
                continue
        parts.append((frame, frame, 1))
    return ",".join(
        f"{first}" if first == last else f"{first}-{last}" + ("" if step == 1 else f"x{step}")
        for first, last, step in parts
    )
