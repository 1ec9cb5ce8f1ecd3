"""Every kernel with a check of every index: ``python tests/bounds.py [PRESET …]``, on an empty cache of its own.

An index out of bounds reads or writes what is beside an array, in silence. Here Numba compiles a look at each index
into the kernels (which takes minutes), and small scenes of all presets, of rods and of labels run them. First four
kernels that go wrong on purpose have to be noticed, as a device function, as a function and in a parallel loop.
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

os.environ |= {"NUMBA_BOUNDSCHECK": "1", "NUMBA_NUM_THREADS": "1", "STRANDCLI_COMPILERS": "0", "STRANDCLI_DEBUG": "1"}
if "STRANDCLI_BOUNDS_CACHE" in os.environ:
    os.environ["STRANDCLI_CACHE_DIR"] = os.environ["STRANDCLI_BOUNDS_CACHE"]

import numpy as np

from strandcli.cli.main import main
from strandcli.jit import device, function, inlined, parallel, prange
from strandcli.jit.pruned import device_where

ROOT = Path(__file__).resolve().parents[1]
SMALL = ("--strands", "60", "--particles", "6", "--size", "40x32", "--threads", "1", "-q", "--overwrite")
PRESETS = sorted(path.stem for path in (ROOT / "presets").glob("*.yaml"))
STILL, OF_FILES = ("groom",), ("groom", "rope")
"""Presets of one frame, and those whose strands are from a file."""
LABELS = ("gaussianhaircut", "hairstep", "nerfstudio", "neuralhaircut")
SQUARE = ("--size", "32x32")
"""Most of these layouts have square pictures alone."""


@device
def last_of_device(values):  # type: ignore[no-untyped-def]
    return values[values.shape[0]]


@inlined
def last_of_inlined(values):  # type: ignore[no-untyped-def]
    return values[values.shape[0]]


@device_where(lambda kind: True, None)
def last_of_chosen(values):  # type: ignore[no-untyped-def]
    return values[values.shape[0]]


@function
def by_chosen(values):  # type: ignore[no-untyped-def]
    return last_of_chosen(values)


@function
def by_device(values):  # type: ignore[no-untyped-def]
    return last_of_device(values)


@function
def by_inlined(values):  # type: ignore[no-untyped-def]
    return last_of_inlined(values)


@parallel
def in_a_loop(values):  # type: ignore[no-untyped-def]
    for i in prange(values.shape[0]):
        values[i] = last_of_device(values)


def unnoticed() -> list[str]:
    """The kernels that go wrong on purpose and are not noticed."""
    values, missed = np.ones(3), []
    kernels = {"device": by_device, "inlined": by_inlined, "chosen by type": by_chosen, "parallel": in_a_loop}
    for name, kernel in kernels.items():
        try:
            kernel(values)
        except (IndexError, SystemError):
            continue
        missed.append(name)
    return missed


def scenes(presets: list[str]) -> dict[str, list[str]]:
    """Commands by what they run."""
    small = {name: SMALL if name not in OF_FILES else SMALL[4:] for name in presets}
    found = {name: ["render", name, "-f", "1" if name in STILL else "2", "--no-html", *small[name]] for name in presets}
    for layout in LABELS if presets == PRESETS else ():
        found[f"labels {layout}"] = ["dataset", "minimal", "--layout", layout, "--views", "1", *SMALL, *SQUARE]
    return found


def run(presets: list[str]) -> int:
    """Run all; returns how many went wrong."""
    missed = unnoticed()
    print(f"seeded faults that are not noticed: {missed or 'none'}", flush=True)
    wrong = len(missed)
    with tempfile.TemporaryDirectory() as name:
        for what, words in scenes(presets).items():
            code = main([*words, "-o", str(Path(name, what.replace(" ", "-")))])
            print(f"{what}: exit code {code}", flush=True)
            wrong += code != 0
    return wrong


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:] or PRESETS) > 0)
