"""Renders on a cache of kernels whose bits fell over, and many first renders at once on one that is empty."""

from __future__ import annotations

import os
import random
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from forked_runs import Forks

DARK = "lights=[{kind: directional, direction: [-0.6, -0.5, -0.8], shadow: {model: 'off'}}]"
TINY = (
    "--strands", "200", "--particles", "6", "--size", "48x40", "--threads", "1", "-q", "-f", "1", "--overwrite",
    "--quality", "draft", "--set", "solids=[]", "--set", DARK, "--set", "time.preroll=0",
)  # fmt: skip
"""A picture of few kernels, all of which are run: half of what a case costs is to compile anew what was damaged."""
FRAME = "frame_0001.png"
SHARE = 0.8
"""Of the memory that is free."""
EACH = 90e6
"""Bytes that a fork has of its own at most."""


def job(out: Path) -> list[str]:
    """The arguments of a render."""
    return ["render", "minimal", *TINY, "-o", str(out)]


def picture(out: Path) -> bytes:
    """The frame; b"" where there is none."""
    path = out / FRAME
    return path.read_bytes() if path.exists() else b""


def damaged_caches(numbers: range, folder: Path) -> Iterator[Counter[str]]:
    """Let bits of kernels in a cache fall over, one kernel or, each twentieth time, three, and render."""
    with Forks(folder / "cache") as forks:
        assert forks.run([job(folder / "whole")]) == [0]
        whole = picture(folder / "whole")
        assert whole
        entries = sorted((folder / "cache").rglob("*.kernel"))
        for one in entries:
            os.utime(one, (0, 0))
        assert forks.run([job(folder / "whole")]) == [0]
        # an entry that is read gets a new time; others are only read where a kernel that contains them is compiled
        kernels = [one for one in entries if one.stat().st_mtime > 0]
        assert len(kernels) > 10
        sound = {one: one.read_bytes() for one in kernels}
        for number in numbers:
            chance, found = random.Random(1_000_000 + number), Counter[str]()
            struck = [chance.choice(kernels)] if number % 20 else chance.sample(kernels, 3)
            for one in struck:
                data = bytearray(sound[one])
                for bit in chance.sample(range(8 * len(data)), chance.choice((1, 1, 8))):
                    data[bit // 8] ^= 1 << bit % 8
                one.write_bytes(data)
            damaged = {one: one.read_bytes() for one in struck}
            (folder / "damaged" / FRAME).unlink(missing_ok=True)
            (code,) = forks.run([job(folder / "damaged")])
            found["done" if code == 0 else f"exit code {code}"] += 1
            found["frames that differ"] += picture(folder / "damaged") != whole
            found["kernels struck"] += len(struck)
            found["damage left"] += sum(one.exists() and one.read_bytes() == data for one, data in damaged.items())
            for one in struck:
                one.write_bytes(sound[one])
            yield found


def cold_starts(numbers: range, folder: Path) -> Iterator[Counter[str]]:
    """Render on one cache folder that is empty at first, all at once, or as many as there is memory for."""
    from strandcli.plan.free import available_memory

    free = available_memory()
    fits = len(numbers) if free is None else max(int(SHARE * free / EACH), 1)
    for first in range(0, len(numbers), fits):
        part, cache, found = numbers[first : first + fits], folder / f"cache_{first}", Counter[str]()
        with Forks(cache) as forks:
            codes = forks.run([job(folder / f"start_{number}") for number in part])
        for code in codes:
            found["done" if code == 0 else f"exit code {code}"] += 1
        found["cases"] = len(part)
        found["at the same moment"] = len(part)
        found["pictures that differ"] = len({picture(folder / f"start_{number}") for number in part}) - 1
        found["parts left"] = len(list(cache.rglob("*.part")))
        yield found
