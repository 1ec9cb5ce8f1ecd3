"""The folder of compiled kernels: whether they can be kept and are run, how much there is, and what is damaged."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ..compiling.folder import ENTRY, MOST_BYTES, cache, writers
from ..counted import counted
from .finding import NOTE, OK, Finding

FIRST_BYTES = b"strandcli kernel "
"""Of every kernel's file."""
LEAST_BYTES = 1000
"""The smallest kernel has some ten thousand; a file cut short by a full disk or a crash has fewer."""


def kept() -> Iterator[Finding]:
    """Whether kernels are kept for the next run, in a folder of this user's alone, and how many there are."""
    from ..output.files import megabytes

    folder = cache.shared or cache.path
    if cache.trouble is not None and cache.shared is None:
        yield Finding("cache", NOTE, cache.trouble)
        return
    entries = [one for one in folder.iterdir() if ENTRY.fullmatch(one.name)]
    size = sum(one.lstat().st_size for one in entries)
    text = f"{folder}: {counted(len(entries), 'kernel or module', 'kernels and modules')}, {megabytes(size)}"
    broken = [one for one in entries if damaged(one)]
    if broken:
        some = f"{len(broken)} not used, such as {broken[0].name}: damaged, or writable for others"
        advice = "nothing: they are compiled anew when they are needed"
        if cache.shared is not None:
            advice = "have who may write there remove them and run 'strandcli warmup PRESET'"
        yield Finding("cache", NOTE, f"{text}; {some}", advice)
    elif cache.shared is not None:
        text += "; they are read, and cannot be written"
        advice = "nothing where all is there that is drawn; else have who may write there run 'strandcli warmup PRESET'"
        yield Finding("cache", NOTE, text, advice)
    elif size > MOST_BYTES:
        yield Finding("cache", NOTE, text, "nothing: what was not used for longest is removed once a day")
    else:
        yield Finding("cache", OK, text + ("" if entries else "; the first run compiles, about a minute"))


def damaged(entry: Path) -> bool:
    """Whether an entry is not used, for it clearly is none or others may change it; a run looks closer, at a hash of
    its content."""
    try:
        if writers(entry.lstat()):
            return True
        if entry.suffix != ".kernel":
            return False
        if not entry.is_file() or entry.stat().st_size < LEAST_BYTES:
            return True
        with entry.open("rb") as file:
            return file.read(len(FIRST_BYTES)) != FIRST_BYTES
    except OSError:
        return True
