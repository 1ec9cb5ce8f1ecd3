"""All that is looked at, in order; last a small picture, drawn by a process of its own."""

from __future__ import annotations

import functools
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from .. import doctor
from . import BROKEN, NOTE, OK, Finding

GOLDEN = Path(__file__).parent / "golden"
"""The picture, its hashes by class of machine, and how it is drawn: `strandcli golden update` makes it anew."""
PATIENCE = 900.0
"""Seconds: on an empty cache kernels are compiled, a minute on one core that is free."""


def picture() -> Iterator[Finding]:
    """Whether this machine draws a small scene as it should."""
    package = str(Path(__file__).parents[2])
    paths = [package, *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    command = [sys.executable, "-m", "strandcli.doctor.examine"]
    try:
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        yield Finding("self-test", BROKEN, f"not done after {PATIENCE:g} s", "run it on a machine with less to do")
        return
    yield self_test(done.returncode, done.stdout, done.stderr)


def self_test(code: int, out: str, err: str) -> Finding:
    """The finding of a self-test that ended with a code and has printed this."""
    if code < 0:
        name = signal.Signals(-code).name if -code in set(signal.Signals) else str(-code)
        return Finding(
            "self-test", BROKEN, f"the process crashed ({name}): compiled code does not run here",
            "remove the kernel cache; if it stays, report it with this output",
        )  # fmt: skip
    try:
        data = json.loads(out.splitlines()[-1])
    except (ValueError, IndexError):
        last = (err.strip().splitlines() or [f"exit code {code}"])[-1]
        return Finding("self-test", BROKEN, last, "report it with this output")
    if data.get("error"):
        return Finding("self-test", BROKEN, data["error"], "see the message; report it if it does not help")
    text = f"a small picture in {data['seconds']:.1f} s"
    text += f", of which {data['compiling']:.1f} s compiling" if data["compiling"] > 0 else ""
    text += f", by {data['layer']}: {data['why']}"
    if not data["matches"]:
        return Finding("self-test", BROKEN, text, "pictures are wrong here; report it with this output")
    slow = data["seconds"] - data["compiling"] > 20
    return Finding("self-test", NOTE if slow else OK, text, "something else uses this machine's cores" if slow else "")


CHECKS: dict[str, Callable[[], Iterator[Finding]]] = {
    "versions": doctor.versions, "numba": doctor.numba_settings, "threading": doctor.threading_layers,
    "processor": doctor.processor, "threads": doctor.threads, "memory": doctor.memory, "disk": doctor.disk,
    "cache": doctor.kernels, "presets": doctor.presets, "bytecode": doctor.bytecode, "extras": doctor.optional,
    "self-test": picture,
}  # fmt: skip


def examine() -> Iterator[Finding]:
    """Findings one by one; what a check raises is one, too. Without Numba nothing is drawn."""
    drawable = True
    for name, check in CHECKS.items():
        if name == "self-test" and not drawable:
            yield Finding(name, BROKEN, "not run", "mend numba first")
            continue
        try:
            for one in check():
                drawable = drawable and not (one.check in ("numba", "versions", "threads") and one.state == BROKEN)
                yield one
        except Exception as error:  # a doctor that dies of the disease tells nothing
            yield Finding(name, BROKEN, f"{type(error).__name__}: {error}", "report it with this output")


def draw() -> dict[str, Any]:
    """Draw the picture in this process; returns what `self_test` tells."""
    from ..compiling import runtime
    from ..study import golden

    start = time.perf_counter()
    runtime.start()
    (entry,) = golden.read_entries(GOLDEN)
    with tempfile.TemporaryDirectory() as folder:
        result = golden.check(GOLDEN, entry, Path(folder), functools.partial(golden.draw, threads=None))
    return {
        "matches": result.matches, "why": result.words, "seconds": time.perf_counter() - start,
        "compiling": runtime.compile_seconds(), "layer": runtime.machine()["threading_layer"],
    }  # fmt: skip


def main() -> None:
    """Print the result as one line of JSON."""
    try:
        data = draw()
    except Exception as error:  # the process that has started this one tells it
        data = {"error": " ".join(f"{type(error).__name__}: {error}".split())}
    print(json.dumps(data), flush=True)


if __name__ == "__main__":
    main()
