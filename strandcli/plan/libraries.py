"""Memory that libraries' files take in a process: as many of their pages as the system maps.

That differs twofold from one environment to the next with the same libraries, by how their files lie in the page cache.
It changes as well as that cache is emptied and filled. It is read at the end of each render, and where the machine's
speed is measured, and kept for each environment.
"""

from __future__ import annotations

import json
import sys
from importlib.util import find_spec
from pathlib import Path

from ..compiling.folder import cache

STATUS = Path("/proc/self/status")
FILE = "libraries.json"
USUAL = 116_000_000
"""Bytes where nothing was measured: most of it LLVM's library."""
LEAST, MOST = 20_000_000, 1_000_000_000
"""Bytes that are believed."""
NEAR = 2_000_000
"""Bytes by which what is kept may be off, before it is written anew."""
ENVIRONMENTS = 20
"""That are remembered."""


def mapped_bytes(status: Path = STATUS) -> int:
    """Return the bytes of files that are mapped into this process; 0 where the system does not tell. All of them are
    the interpreter's and libraries': strandcli maps none."""
    try:
        lines = status.read_text(encoding="utf-8", errors="replace").splitlines()
        return sum(1024 * int(line.split()[1]) for line in lines if line.startswith("RssFile:"))
    except (OSError, ValueError, IndexError):
        return 0


class _Known:
    """What plans reckon with."""

    bytes = USUAL


def known_bytes() -> int:
    """Return what they take: as `look` has found, else `USUAL`."""
    return _Known.bytes


def look() -> None:
    """Have plans reckon with what was measured in this environment, if that was done; for commands, since it chooses
    the cache folder."""
    _Known.bytes = _kept().get(_environment(), USUAL)


def keep_mapped(before: int = 0) -> None:
    """Keep what is mapped into this process, or was ``before``, bytes, if it is strandcli's own and has run kernels:
    into others' more may be, as by what they have imported besides, and LLVM's library is most of it."""
    if _is_own() and "llvmlite.binding" in sys.modules:
        keep(max(before, mapped_bytes()))


def _is_own() -> bool:
    program = sys.modules["__main__"]
    spec, file = getattr(program, "__spec__", None), getattr(program, "__file__", None)
    by_module = spec is not None and spec.name.partition(".")[0] == "strandcli"
    return by_module or (file is not None and Path(file).stem == "strandcli")


def keep(measured: int) -> None:
    """Keep what was measured of this environment, if it can be believed and is news. Less than what is kept counts for
    a quarter: the system may have taken pages back that had counted before."""
    known, environment = _kept(), _environment()
    if not LEAST <= measured <= MOST:
        return
    last = known.pop(environment, None)
    if last is not None and measured < last:
        measured = last - (last - measured) // 4
    if last is None or abs(measured - last) > NEAR:
        latest = dict(list({**known, environment: measured}.items())[-ENVIRONMENTS:])
        cache.write(cache.path / FILE, json.dumps(latest, indent=1).encode())


def _environment() -> str:
    """The folder of LLVM's library, which is not imported."""
    found = find_spec("llvmlite")
    return "" if found is None or found.origin is None else str(Path(found.origin).parent)


def _kept() -> dict[str, int]:
    try:
        data = json.loads(cache.find(FILE).read_text(encoding="utf-8"))
        return {str(name): one for name, one in data.items() if type(one) is int and LEAST <= one <= MOST}
    except (OSError, ValueError, AttributeError, RecursionError):
        return {}
