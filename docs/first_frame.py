"""Time the first frame of a preset: on an empty kernel cache, and again. Prints JSON.

python docs/first_frame.py PRESET
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path


def seconds(preset: str, cache: Path, out: Path) -> float:
    """Wall seconds of ``strandcli render PRESET -f 1`` with the cache in a folder."""
    command = [str(Path(sys.executable).parent / "strandcli"), "render", preset, "-f", "1", "-o", str(out), "-q"]
    began = time.perf_counter()
    subprocess.run(command, check=True, env={**os.environ, "STRANDCLI_CACHE_DIR": str(cache)})
    return time.perf_counter() - began


def main() -> None:
    """Draw twice: the second run finds kernels and the state at frame 1 in the cache."""
    with tempfile.TemporaryDirectory() as folder:
        cache, out = Path(folder) / "cache", Path(folder) / "out"
        cold, warm = (seconds(sys.argv[1], cache, out / str(turn)) for turn in range(2))
    print(json.dumps({"preset": sys.argv[1], "cold": cold, "warm": warm}))


if __name__ == "__main__":
    main()
