#!/usr/bin/env python3
"""How many guides of a file of strands are enough: how far off strands are that follow, and what it takes.

    python examples/guides.py preset.yaml --guides 250 500 1000 2000

The preset has `emitter.groom` and rules that move it. Every number of guides is compared with the same preset in which
all strands are simulated, at even frames: the mean and the 95th percentile of the distance of a strand's points, over
the mean length; and the seconds of one thread for a frame of simulating and of following.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import numpy as np
import numpy.typing as npt

import strandcli
from strandcli.compiling import runtime
from strandcli.draw.common.scratch import Scratch
from strandcli.groom.blocks import unpack
from strandcli.groom.followers import Followers
from strandcli.run.stages import RunOptions, SimulationStage

COMPARED = 4
"""Frames, evenly chosen; the last one is among them."""
Strands = npt.NDArray[np.float32]


def run(preset: str, guides: int, last: int) -> tuple[list[Strands], float, float, int]:
    """Strands (k, points, 3) in some frames, seconds of simulating and of following a frame, and the guides."""
    scene = strandcli.load(preset, settings={"emitter.groom.guides": guides})
    stage = SimulationStage(scene, [1], None, RunOptions())
    children, scratch = stage.children, Scratch()
    assert isinstance(children, Followers)
    frames = sorted({round(frame) for frame in np.linspace(1, last, COMPARED + 1)})[1:]
    everybody = np.arange(children.groom.strands, dtype=np.int32)
    found, simulating, following = [], [], []
    stage.begin(2)  # which loads kernels
    for frame in range(3, last + 1):
        began = time.process_time()
        moved = stage.begin(frame)
        middle = time.process_time()
        out, _ = children.grow(moved.positions, moved.lengths, (frame - 1) / scene.time.fps, everybody, scratch)
        simulating.append(middle - began)
        following.append(time.process_time() - middle)
        if frame in frames:
            found.append(unpack(out, children.groom.strands)[:, 1:])
    return found, min(simulating), min(following), stage.groom.strands


def main(arguments: list[str] | None = None) -> int:
    """Print a line for each number of guides."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("preset")
    parser.add_argument("--guides", type=int, nargs="+", default=[250, 500, 1000, 2000])
    parser.add_argument("--frames", type=int, default=24)
    given = parser.parse_args(arguments)
    runtime.start(1, None)
    every: Any = None
    for guides in [10_000_000, *sorted(given.guides, reverse=True)]:
        strands, simulating, following, count = run(given.preset, guides, max(given.frames, 4))
        if every is None:
            every = strands
        off = [np.linalg.norm(one - other, axis=2) for one, other in zip(strands, every, strict=True)]
        length = np.linalg.norm(np.diff(every[0], axis=1), axis=2).sum(1).mean()
        each = np.concatenate([one.mean(1) for one in off]) / length
        print(
            f"{count:9,} guides: {100 * each.mean():6.3f} % mean, {100 * np.quantile(each, 0.95):6.3f} % for 95 % of "
            f"strands; simulate {simulating:.4f} s, follow {following:.4f} s a frame",
            flush=True,
        )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
