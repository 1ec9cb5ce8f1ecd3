"""Kinds of processors that kernels are compiled for, each with what all machines of the kind have.

All of x86-64 have fused multiplication and addition, on which the bits of pictures depend: kernels for processors
without, such as x86-64-v2, would draw other pixels.
"""

from __future__ import annotations

import functools
import os
import platform
import sys

from ..errors import UsageError

V3 = (
    "64bit", "avx", "avx2", "bmi", "bmi2", "cmov", "crc32", "cx16", "cx8", "f16c", "fma", "fxsr", "lzcnt", "mmx",
    "movbe", "popcnt", "sahf", "sse", "sse2", "sse3", "sse4.1", "sse4.2", "ssse3", "xsave",
)  # fmt: skip
LEVELS: dict[str, tuple[str, ...]] = {
    "x86-64-v3": V3,
    "x86-64-v4": (*V3, "avx512bw", "avx512cd", "avx512dq", "avx512f", "avx512vl"),
    "generic": (),
}
"""LLVM's names of features by its name of the kind; the last one is every 64-bit ARM."""


def choose(level: str) -> None:
    """Have this process and those that it starts compile for a kind of processor; before Numba is imported.

    Raises `UsageError` for a kind that this machine is not of: kernels are run as they are compiled.
    """
    arm = platform.machine().lower() in ("arm64", "aarch64")
    if arm != (level == "generic"):
        raise UsageError(f"--cpu {level}: this machine's processor is {platform.machine()}")
    features = ",".join(f"+{one}" for one in LEVELS[level])
    if lacks := lacking(features):
        raise UsageError(
            f"--cpu {level}: this machine's processor has no {lacks[0]}, and kernels are run to compile them"
        )
    asked = {"NUMBA_CPU_NAME": level, "NUMBA_CPU_FEATURES": features}
    if "numba" in sys.modules and {name: os.environ.get(name) for name in asked} != asked:
        raise UsageError(
            f"--cpu {level}: Numba has been imported by this process already; run 'strandcli' in one of its own"
        )
    os.environ.update(asked)


def lacking(features: str) -> list[str]:
    """The features of an LLVM list, such as ``+avx,-sse4a``, that this machine's processor would need and lacks."""
    here = _features()
    return [one[1:] for one in features.split(",") if one.startswith("+") and not here.get(one[1:])]


@functools.cache
def _features() -> dict[str, bool]:
    import llvmlite.binding as llvm

    return dict(llvm.get_host_cpu_features())
