"""Renders that are killed: ``python tests/kills.py [KILLS [TERMS [CACHES [STARTS]]]]``, and a slice in the tests.

Of renders with --resume and checkpoints that get SIGKILL at random moments, no frame may differ from those of a run
that was left alone, and nothing half-written may have a final name; one that gets SIGTERM ends within 2 s; a kernel
cache in which bits fell over changes no pixel and crashes nothing; nor do many first starts on one cache folder.

What was done is kept in out/kills/counts.json: a run that is stopped goes on from there.
"""

from __future__ import annotations

import contextlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

from forked_runs import ROOT, Forks
from kills_of_caches import cold_starts, damaged_caches

FRAMES = 6
SMALL = ("--strands", "200", "--particles", "6", "--size", "48x40", "--threads", "1", "-q", "--checkpoint", "2")
PATIENCE = 2.0
"""Seconds from SIGTERM to the end."""
SEED = 1
COUNTS = ROOT / "out" / "kills" / "counts.json"


def job(preset: str, out: Path, *more: str, frames: str = f"1-{FRAMES}") -> list[str]:
    """The arguments of a render."""
    return ["render", preset, *SMALL, "-f", frames, "-o", str(out), *more]


def start(arguments: list[str]) -> subprocess.Popen[bytes]:
    """A render in a process of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", "strandcli", *arguments],
        env=os.environ | {"PYTHONPATH": str(ROOT)}, stdout=subprocess.DEVNULL,
    )  # fmt: skip


def frames_in(folder: Path) -> dict[str, bytes]:
    """The frames under their final names."""
    return {one.name: one.read_bytes() for one in sorted(folder.glob("frame_*.png"))}


def kills(numbers: range, folder: Path, preset: str = "minimal") -> Iterator[Counter[str]]:
    """Kill renders, each at a random moment of those that the last has left, and look at what lies there: half of them
    at any time, half while files are written, right after some have come into the folder.

    Every tenth is a process from its start, the others are forks of one that has imported all, for what they write
    comes after that.
    """
    from strandcli.compiling.folder import cache

    with Forks(cache.path.parent) as forks:
        assert forks.run([job(preset, folder / "whole")]) == [0]
        begun = time.monotonic()
        assert forks.run([job(preset, folder / "whole", "--overwrite")]) == [0]
        took = time.monotonic() - begun
        whole, out = frames_in(folder / "whole"), folder / "killed"
        for number in numbers:
            chance, found = random.Random(SEED * 1_000_000 + number), Counter[str]()
            files, after = (0, chance.uniform(0.2, 1.3) * took) if number % 2 else (chance.randint(1, 6), 0.0)
            after += chance.uniform(0.0, 0.03)
            code = _killed(job(preset, out, "--resume"), forks, after, number % 10 == 9, Arrivals(out, files))
            found["killed" if code == -signal.SIGKILL else f"exit code {code}" if code else "was done before"] += 1
            for name, data in frames_in(out).items():
                found["frames"] += 1
                found["frames that differ"] += data != whole.get(name)
            if len(frames_in(out)) == FRAMES or number == numbers[-1]:
                found["runs to the end"] += 1
                found["exit code at the end"] += forks.run([job(preset, out, "--resume")]) != [0]
                found["frames that differ"] += sum(data != whole.get(name) for name, data in frames_in(out).items())
                found["frames missing"] += FRAMES - len(frames_in(out))
                found["left behind"] += len([one for one in out.rglob("*") if one.name.startswith(".")])
                shutil.rmtree(out)
            yield found


class Arrivals:
    """Waits for so many new files in a folder and in those within it."""

    def __init__(self, folder: Path, count: int) -> None:
        self._folder, self._count = folder, count
        self._before = set(folder.rglob("*"))

    def wait(self, process: int) -> None:
        """Until they are there, or the process is not."""
        while Path(f"/proc/{process}").exists() and len(set(self._folder.rglob("*")) - self._before) < self._count:
            time.sleep(0.001)


def _killed(arguments: list[str], forks: Forks, after: float, from_start: bool, arrivals: Arrivals) -> int:
    """The exit code of a render that gets SIGKILL so many seconds after files, if it has not ended before."""
    if from_start:
        process = start(arguments)
        time.sleep(after + 1.0)  # Python, NumPy and Numba come first
        process.kill()
        return process.wait()
    (number,) = forks.start([arguments])
    arrivals.wait(number)
    time.sleep(after)
    with contextlib.suppress(ProcessLookupError):  # it has ended, and the other process has waited for it
        os.kill(number, signal.SIGKILL)
    return forks.codes()[0]


def terms(numbers: range, folder: Path, preset: str = "minimal") -> Iterator[Counter[str]]:
    """End renders by SIGTERM at random moments."""
    for number in numbers:
        chance, found, out = random.Random(SEED * 1_000_000 + number), Counter[str](), folder / f"term_{number}"
        process = start(job(preset, out, "--set", "time.frames=2000", frames="1-2000"))
        time.sleep(chance.uniform(1.0, 5.0))
        before = cpu_seconds(process.pid)
        process.terminate()
        begun, usage = time.monotonic(), os.wait4(process.pid, 0)
        took = time.monotonic() - begun
        code = process.returncode = os.waitstatus_to_exitcode(usage[1])
        found["ended late"] += took > PATIENCE
        found["ms of processor time to the end"] += round(1000 * (usage[2].ru_utime + usage[2].ru_stime - before))
        found["ms to the end"] += round(1000 * took)
        found["done" if code == 143 else f"exit code {code}"] += 1
        found["temporary files"] += len(list(out.glob(".*.tmp*")))
        yield found


def cpu_seconds(process: int) -> float:
    """What a process has used so far, with the system's work for it."""
    fields = Path(f"/proc/{process}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


FAULTS = ("differ", "missing", "left", "late", "temporary", "exit code")
"""In the words of what must not be found."""
PARTS: dict[str, Callable[[range, Path], Iterator[Counter[str]]]] = {
    "kills": kills, "terms": terms, "damaged_caches": damaged_caches, "cold_starts": cold_starts
}  # fmt: skip


def main() -> None:
    """Do what of it was not done yet, print what was found, and end with 1 where something is wrong."""
    counts = [int(one) for one in sys.argv[1:]] + [200, 20, 1000, 200][len(sys.argv) - 1 :]
    COUNTS.parent.mkdir(parents=True, exist_ok=True)
    wrong = False
    for (name, part), count in zip(PARTS.items(), counts, strict=True):
        record: dict[str, Counter[str]] = {}
        if COUNTS.exists():
            record = {key: Counter(found) for key, found in json.loads(COUNTS.read_text(encoding="utf-8")).items()}
        total = record.setdefault(name, Counter())
        if total["cases"] < count:
            with tempfile.TemporaryDirectory() as folder:
                for found in part(range(total["cases"], count), Path(folder)):
                    total["cases"] += found.pop("cases", 1)
                    total.update(found)
                    COUNTS.with_suffix(".part").write_text(json.dumps(record), encoding="utf-8")
                    COUNTS.with_suffix(".part").replace(COUNTS)
        print(name, dict(total), flush=True)
        wrong = wrong or any(number for words, number in total.items() if any(one in words for one in FAULTS))
    sys.exit(wrong)


if __name__ == "__main__":
    main()
