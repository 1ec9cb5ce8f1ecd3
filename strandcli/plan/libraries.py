"""Memory that libraries' files take in a process: as many of their pages as the system maps.

That differs twofold from one environment to the next with the same libraries, by how their files lie in the page cache.
It is measured with the machine's speed, where kernels run anyhow, and kept for each environment.
"""

from __future__ import annotations

import json
from importlib.util import find_spec
from pathlib import Path

from ..compiling.folder import cache

SMAPS = Path("/proc/self/smaps")
FILE = "libraries.json"
USUAL = 120_000_000
"""Bytes where nothing was measured: most of it LLVM's library."""
LEAST, MOST = 20_000_000, 1_000_000_000
"""Bytes that are believed."""
ENVIRONMENTS = 20
"""That are remembered."""


def mapped_bytes(smaps: Path = SMAPS) -> int:
    """Return the bytes of libraries' files that are mapped into this process; 0 where the system does not tell."""
    total, library = 0, False
    try:
        lines = smaps.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return 0
    for line in lines:
        words = line.split(None, 5)
        if len(words) >= 5 and not words[0].endswith(":"):  # a mapping; its file is the last word
            library = len(words) > 5 and ".so" in words[5].strip().rpartition("/")[2]
        elif library and words[:1] == ["Rss:"]:
            total += 1024 * int(words[1])
    return total


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


def keep(measured: int) -> None:
    """Keep what was measured of this environment, if it can be believed."""
    if LEAST <= measured <= MOST:
        kept = {**{name: one for name, one in _kept().items() if name != _environment()}, _environment(): measured}
        latest = dict(list(kept.items())[-ENVIRONMENTS:])
        cache.write(cache.path / FILE, json.dumps(latest, indent=1).encode())


def _environment() -> str:
    """The folder of LLVM's library, which is not imported."""
    found = find_spec("llvmlite")
    return "" if found is None or found.origin is None else str(Path(found.origin).parent)


def _kept() -> dict[str, int]:
    try:
        data = json.loads((cache.path / FILE).read_text(encoding="utf-8"))
        return {str(name): one for name, one in data.items() if type(one) is int and LEAST <= one <= MOST}
    except (OSError, ValueError, AttributeError, RecursionError):
        return {}
