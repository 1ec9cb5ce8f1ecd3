"""Memory and cores that a process may use: of the system, and of a control group of Linux, as of a container's."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

SHARE = 0.8
"""Of what is free, what a run may be planned to take: the estimate may be 15 % off, and other programs grow."""
ROOT = Path("/sys/fs/cgroup")
UNLIMITED = 1 << 60
"""Bytes; control groups of version 1 say a number about 2^63 where there is no limit."""


def available_memory() -> int | None:
    """Return the available bytes, by the system and by the control groups of this process; None if neither is known."""
    found = []
    try:
        with open("/proc/meminfo", encoding="ascii") as lines:
            found += [1024 * int(line.split()[1]) for line in lines if line.startswith("MemAvailable")]
    except OSError:
        pass
    left = memory_left()
    if left is not None:
        found.append(left)
    return min(found, default=None)


def folders(controller: str, root: Path = ROOT, group: Path = Path("/proc/self/cgroup")) -> Iterator[Path]:
    """Folders of this process's group and of those that it is in, of either version."""
    try:
        lines = group.read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    for line in lines:
        _, names, path = (*line.split(":", 2), "", "")[:3]
        if names == "" or controller in names.split(","):
            base = root if names == "" else root / controller
            place = base / path.lstrip("/")
            yield from (one for one in (place, *place.parents) if one == base or base in one.parents)
    yield from (root, root / controller)  # inside a container


def cores() -> int:
    """Cores that this process may run on."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def quota(root: Path = ROOT, group: Path = Path("/proc/self/cgroup")) -> float | None:
    """Cores' worth of time that the process may use; None where there is no such limit."""
    found = []
    for folder in folders("cpu", root, group):
        words = _read(folder / "cpu.max").split() or [
            _read(folder / "cpu.cfs_quota_us"), _read(folder / "cpu.cfs_period_us")
        ]  # fmt: skip
        if len(words) == 2 and all(word.isdigit() for word in words) and int(words[1]) > 0:
            found.append(int(words[0]) / int(words[1]))
    return min(found, default=None)


def compilers() -> int:
    """Processes that may compile at once: as many as ``STRANDCLI_COMPILERS`` says, else one a core that may be used."""
    asked = os.environ.get("STRANDCLI_COMPILERS", "")
    return int(asked) if asked.isdecimal() else min(cores(), max(1, int(quota() or cores())))


def memory(root: Path = ROOT, group: Path = Path("/proc/self/cgroup")) -> int | None:
    """Bytes of memory that the process's groups may hold; None where there is no such limit."""
    return min((limit for limit, _ in _memory(root, group)), default=None)


def memory_left(root: Path = ROOT, group: Path = Path("/proc/self/cgroup")) -> int | None:
    """Bytes that the process's groups may still take; None where there is no such limit."""
    return min((limit - int(used) for limit, used in _memory(root, group) if used.isdigit()), default=None)


def _memory(root: Path, group: Path) -> Iterator[tuple[int, str]]:
    """The limit of each group, bytes, and what it says that it holds."""
    for folder in folders("memory", root, group):
        word = _read(folder / "memory.max") or _read(folder / "memory.limit_in_bytes")
        if word.isdigit() and int(word) < UNLIMITED:
            yield int(word), _read(folder / "memory.current") or _read(folder / "memory.usage_in_bytes")


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="ascii").strip()
    except (OSError, ValueError):
        return ""
