"""Renders that are killed: ``python tests/kills.py [KILLS [TERMS [CACHES [STARTS]]]]``, and a slice in the tests.

Of renders with --resume and checkpoints that get SIGKILL at random moments, no frame may differ from those of a run
that was left alone, and nothing half-written may have a final name; one that gets SIGTERM ends within 2 s; a kernel
cache in which bits fell over changes no pixel and crashes nothing; nor do many first starts on one cache folder.
"""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FRAMES = 6
SMALL = ("--strands", "200", "--particles", "6", "--size", "48x40", "--threads", "1", "-q", "--checkpoint", "2")
PATIENCE = 2.0
"""Seconds from SIGTERM to the end."""


def start(
    preset: str, out: Path, *more: str, cache: Path | None = None, frames: str = f"1-{FRAMES}"
) -> subprocess.Popen[bytes]:
    """A render in a process of its own."""
    env = os.environ | {"PYTHONPATH": str(ROOT)} | ({} if cache is None else {"STRANDCLI_CACHE_DIR": str(cache)})
    return subprocess.Popen(
        [sys.executable, "-m", "strandcli", "render", preset, *SMALL, "-f", frames, "-o", str(out), *more],
        env=env, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
    )  # fmt: skip


def finished(process: subprocess.Popen[bytes]) -> int:
    """The exit code; what it said is told where that is none of a good end."""
    _, told = process.communicate()
    if process.returncode not in (0, -signal.SIGKILL):
        print(told.decode(errors="replace"), file=sys.stderr)
    return process.returncode


def frames_in(folder: Path) -> dict[str, bytes]:
    """The frames under their final names."""
    return {one.name: one.read_bytes() for one in sorted(folder.glob("frame_*.png"))}


def kills(count: int, seed: int, folder: Path, preset: str = "minimal") -> Counter[str]:
    """Kill ``count`` renders, each at a random moment of those that the last has left, and look at what lies there."""
    chance, found = random.Random(seed), Counter[str]()
    assert finished(start(preset, folder / "whole")) == 0
    begun = time.monotonic()
    assert finished(start(preset, folder / "whole", "--overwrite")) == 0
    took = time.monotonic() - begun
    whole, out = frames_in(folder / "whole"), folder / "killed"
    for _ in range(count):
        process = start(preset, out, "--resume")
        time.sleep(chance.uniform(0.3, 1.05) * took)
        process.kill()
        found["killed" if finished(process) == -signal.SIGKILL else "was done before"] += 1
        for name, data in frames_in(out).items():
            found["frames"] += 1
            found["frames that differ"] += data != whole.get(name)
        if len(frames_in(out)) == FRAMES:
            assert finished(start(preset, out, "--resume")) == 0
            left = [one for one in out.rglob("*") if one.name.startswith(".")]
            found["left behind"] += len(left)
            shutil.rmtree(out)
    assert finished(start(preset, out, "--resume")) == 0
    found["frames that differ"] += sum(data != whole[name] for name, data in frames_in(out).items())
    found["frames missing"] += FRAMES - len(frames_in(out))
    return found


def terms(count: int, seed: int, folder: Path, preset: str = "minimal") -> Counter[str]:
    """End renders by SIGTERM at random moments."""
    chance, found = random.Random(seed), Counter[str]()
    for number in range(count):
        process = start(preset, folder / f"term_{number}", "--set", "time.frames=2000", frames="1-2000")
        time.sleep(chance.uniform(1.0, 5.0))
        process.terminate()
        begun = time.monotonic()
        process.communicate()
        found["ended late"] += time.monotonic() - begun > PATIENCE
        found["done" if process.returncode == 143 else f"exit code {process.returncode}"] += 1
        found["temporary files"] += len(list((folder / f"term_{number}").glob(".*.tmp*")))
    return found


def damaged_caches(count: int, seed: int, folder: Path, preset: str = "minimal") -> Counter[str]:
    """Let bits of kernels in a cache fall over, half of them in one entry, half in all, and render."""
    chance, found, cache = random.Random(seed), Counter[str](), folder / "cache"
    assert finished(start(preset, folder / "whole", "--overwrite", cache=cache, frames="2")) == 0
    whole = frames_in(folder / "whole")["frame_0002.png"]
    kernels = sorted(cache.rglob("*.kernel"))
    sound = {one: one.read_bytes() for one in kernels}
    for number in range(count):
        for one, data in sound.items():
            one.write_bytes(data)
        for one in [chance.choice(kernels)] if number % 20 else chance.sample(kernels, 3):
            data = bytearray(sound[one])
            for _ in range(chance.choice((1, 1, 8))):
                data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
            one.write_bytes(data)
        code = finished(start(preset, folder / "damaged", "--overwrite", cache=cache, frames="2"))
        found["done" if code == 0 else f"exit code {code}"] += 1
        found["frames that differ"] += frames_in(folder / "damaged").get("frame_0002.png") != whole
    return found


def cold_starts(count: int, seed: int, folder: Path, preset: str = "minimal", at_once: int = 8) -> Counter[str]:
    """Render many times on one cache folder that is empty at first, several at once."""
    found, cache = Counter[str](), folder / f"shared_{seed}"
    running: list[tuple[int, subprocess.Popen[bytes]]] = []
    for number in range(count):
        running.append((number, start(preset, folder / f"start_{number}", cache=cache, frames="2")))
        if len(running) == at_once or number == count - 1:
            for _, process in running:
                code = finished(process)
                found["done" if code == 0 else f"exit code {code}"] += 1
            running = []
    pictures = {frames_in(folder / f"start_{number}").get("frame_0002.png") for number in range(count)}
    found["pictures that differ"] = len(pictures) - 1
    found["parts left"] = len(list(cache.rglob("*.part")))
    return found


FAULTS = ("differ", "missing", "left", "late", "temporary", "exit code")
"""In the words of what must not be found."""


def main() -> None:
    """Do all of it, print what was found, and end with 1 where something is wrong."""
    counts = [int(one) for one in sys.argv[1:]] + [200, 20, 1000, 200][len(sys.argv) - 1 :]
    wrong = False
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for what, count in zip((kills, terms, damaged_caches, cold_starts), counts, strict=True):
            if not count:
                continue
            found = what(count, 1, folder)
            print(what.__name__, dict(found), flush=True)
            wrong = wrong or any(number for words, number in found.items() if any(one in words for one in FAULTS))
    sys.exit(wrong)


if __name__ == "__main__":
    main()
