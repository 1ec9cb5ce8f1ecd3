"""Renders that are killed: ``python tests/kills.py [KILLS [TERMS]]``, and a slice in the tests.

Of renders with --resume and checkpoints that get SIGKILL at random moments, no frame may differ from those of a run
that was left alone, and nothing half-written may have a final name; one that gets SIGTERM ends within 2 s.
"""

from __future__ import annotations

import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from cli_runs import environment
from strandcli.cli.main import main as strandcli

FRAMES = 6
SMALL = ("--strands", "200", "--particles", "6", "--size", "48x40", "--threads", "1", "-q", "--checkpoint", "2")
PATIENCE = 2.0
"""Seconds from SIGTERM to the end."""
SEED = 1


def job(out: Path, *more: str, frames: str = f"1-{FRAMES}") -> list[str]:
    """The arguments of a render."""
    return ["render", "minimal", *SMALL, "-f", frames, "-o", str(out), *more]


def start(arguments: list[str]) -> subprocess.Popen[bytes]:
    """A render in a process of its own."""
    command = [sys.executable, "-m", "strandcli", *arguments]
    return subprocess.Popen(command, env=environment(), stdout=subprocess.DEVNULL)


def frames_in(folder: Path) -> dict[str, bytes]:
    """The frames under their final names."""
    return {one.name: one.read_bytes() for one in sorted(folder.glob("frame_*.png"))}


def kills(numbers: range, folder: Path) -> Iterator[Counter[str]]:
    """Kill renders, each at a random moment of those that the last has left, and look at what lies there: half of them
    at any time, half while files are written, right after some have come into the folder."""
    assert strandcli(job(folder / "whole")) == 0
    whole, out = frames_in(folder / "whole"), folder / "killed"
    begun = time.monotonic()
    assert start(job(folder / "whole", "--overwrite")).wait() == 0
    took = time.monotonic() - begun
    for number in numbers:
        chance, found = random.Random(SEED * 1_000_000 + number), Counter[str]()
        files, after = (0, chance.uniform(0.2, 1.3) * took) if number % 2 else (chance.randint(1, 6), 0.0)
        before = set(out.rglob("*"))
        process = start(job(out, "--resume"))
        while process.poll() is None and len(set(out.rglob("*")) - before) < files:
            time.sleep(0.001)
        time.sleep(after + chance.uniform(0.0, 0.03))
        process.kill()
        code = process.wait()
        found["killed" if code == -signal.SIGKILL else f"exit code {code}" if code else "was done before"] += 1
        found["frames that differ"] += sum(data != whole.get(name) for name, data in frames_in(out).items())
        if len(frames_in(out)) == FRAMES or number == numbers[-1]:
            found["exit code at the end"] += strandcli(job(out, "--resume")) != 0
            found["frames that differ"] += sum(data != whole.get(name) for name, data in frames_in(out).items())
            found["frames missing"] += FRAMES - len(frames_in(out))
            found["left behind"] += len([one for one in out.rglob("*") if one.name.startswith(".")])
            shutil.rmtree(out)
        yield found


def terms(numbers: range, folder: Path) -> Iterator[Counter[str]]:
    """End renders by SIGTERM at random moments."""
    for number in numbers:
        chance, found, out = random.Random(SEED * 1_000_000 + number), Counter[str](), folder / f"term_{number}"
        process = start(job(out, "--set", "time.frames=2000", frames="1-2000"))
        time.sleep(chance.uniform(1.0, 5.0))
        process.terminate()
        begun = time.monotonic()
        code = process.wait()
        found["ended late"] += time.monotonic() - begun > PATIENCE
        found["done" if code == 128 + signal.SIGTERM else f"exit code {code}"] += 1
        found["temporary files"] += len(list(out.glob(".*.tmp*")))
        yield found


FAULTS = ("differ", "missing", "left", "late", "temporary", "exit code")
"""In the words of what must not be found."""


def main() -> None:
    """Do both, print what was found, and end with 1 where something is wrong."""
    counts = [int(one) for one in sys.argv[1:]] + [200, 20][len(sys.argv) - 1 :]
    wrong = False
    for part, count in zip((kills, terms), counts, strict=True):
        total: Counter[str] = Counter()
        with tempfile.TemporaryDirectory() as folder:
            for found in part(range(count), Path(folder)):
                total.update(found)
        print(part.__name__, dict(total), flush=True)
        wrong = wrong or any(number for words, number in total.items() if any(one in words for one in FAULTS))
    sys.exit(wrong)


if __name__ == "__main__":
    main()
