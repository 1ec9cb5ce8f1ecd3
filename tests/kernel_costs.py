"""Which kernels each shipped preset needs and how long they compile, for `strandcli/compiling/costs.json`.

`make kernel-costs [COSTS="hair fur"]`, of all presets in some ten minutes. Progress lines count by this file.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from typing import Any

from strandcli.compiling.clock import COSTS
from strandcli.scene import list_presets


def main() -> None:
    """Warm up each preset in a process of its own, on one cache that is empty at first, one kernel after the other."""
    presets: dict[str, Mapping[str, int]] = {}
    seconds: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as cache:
        place = {**os.environ, "STRANDCLI_CACHE_DIR": cache, "STRANDCLI_CACHE_PATH": "", "STRANDCLI_COMPILERS": "1"}
        for name in sys.argv[1:] or [name for name, _ in list_presets()]:
            command = [sys.executable, "-m", "strandcli", "warmup", name, "--json", "--no-progress"]
            data: dict[str, Any] = json.loads(
                subprocess.run(command, env=place, stdout=subprocess.PIPE, check=True).stdout
            )
            presets[name] = data["kernels"]
            for kernel, waited in data["waited"].items():
                seconds[kernel] = round(max(seconds.get(kernel, 0.0), waited / data["kernels"][kernel]), 1)
            found = {"presets": presets, "seconds": dict(sorted(seconds.items()))}
            COSTS.write_text(json.dumps(found, indent=0) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
