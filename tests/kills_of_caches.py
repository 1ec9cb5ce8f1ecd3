"""Renders on a cache of kernels whose bits fell over, and many first renders at once on one that is empty."""

from __future__ import annotations

import fcntl
import os
import random
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

from forked_runs import Forks
from strandcli.compiling.claims import NAME

DARK = "lights=[{kind: directional, direction: [-0.6, -0.5, -0.8], shadow: {model: 'off'}}]"
TINY = (
    "--strands", "200", "--particles", "6", "--size", "48x40", "--threads", "1", "-q", "-f", "1", "--overwrite",
    "--quality", "draft", "--set", "solids=[]", "--set", DARK, "--set", "time.preroll=0",
)  # fmt: skip
"""A picture of few kernels, all of which are run."""
SEVERAL = 6
"""Kernels that are struck at once."""
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
    """Let bits of kernels in a cache fall over, and render: of one kernel each twentieth time, which is compiled anew;
    else of several, in whose place sound ones are laid as soon as they were thrown out, as by a process that has
    claimed them first."""
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
            struck = chance.sample(kernels, SEVERAL if number % 20 else 1)
            for one in struck:
                data = bytearray(sound[one])
                for bit in chance.sample(range(8 * len(data)), chance.choice((1, 1, 8))):
                    data[bit // 8] ^= 1 << bit % 8
                one.write_bytes(data)
            damaged = {one: one.read_bytes() for one in struck}
            (folder / "damaged" / FRAME).unlink(missing_ok=True)
            with Claimed(struck if len(struck) > 1 else []) as claimed:
                (process,) = forks.start([job(folder / "damaged")])
                while Path(f"/proc/{process}").exists():
                    claimed.lay(sound)
                    time.sleep(0.002)
                (code,) = forks.codes()
            found["done" if code == 0 else f"exit code {code}"] += 1
            found["frames that differ"] += picture(folder / "damaged") != whole
            found["kernels struck"] += len(struck)
            found["damage left"] += sum(one.exists() and one.read_bytes() == data for one, data in damaged.items())
            for one in struck:
                one.write_bytes(sound[one])
            yield found


class Claimed:
    """Entries that this process has claimed, so that no other compiles them; a context."""

    def __init__(self, entries: list[Path]) -> None:
        self._entries = list(entries)

    def __enter__(self) -> Claimed:
        self._handle = os.open(self._entries[0].parent / NAME, os.O_RDWR | os.O_CREAT) if self._entries else -1
        for one in self._entries:
            fcntl.lockf(self._handle, fcntl.LOCK_EX, 1, _place(one))
        return self

    def __exit__(self, *error: object) -> None:
        if self._handle >= 0:  # which gives back what is still claimed
            os.close(self._handle)

    def lay(self, sound: Mapping[Path, bytes]) -> None:
        """Put sound entries where there are none any more, and give them back."""
        for one in [one for one in self._entries if not one.exists()]:
            part = one.with_suffix(".laid")
            part.write_bytes(sound[one])
            part.replace(one)
            fcntl.lockf(self._handle, fcntl.LOCK_UN, 1, _place(one))
            self._entries.remove(one)


def _place(entry: Path) -> int:
    """The byte that stands for an entry in the file of claims: the first of its key, with which its name ends."""
    return int.from_bytes(bytes.fromhex(entry.stem.rpartition("-")[2])[:7], "big")


def cold_starts(numbers: range, folder: Path) -> Iterator[Counter[str]]:
    """Render on one cache folder that is empty at first, all at once, or as many as there is memory for."""
    from strandcli.plan.limits import available_memory

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
