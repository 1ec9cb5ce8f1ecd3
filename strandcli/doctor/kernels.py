"""The folder of compiled kernels: whether they can be kept, how much there is, and what is damaged."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from pathlib import Path

from ..compiling.folder import ENTRY, MOST_BYTES, cache
from .finding import NOTE, OK, Finding

FIRST_BYTES = b"strandcli kernel "
"""Of every kernel's file."""
LEAST_BYTES = 1000
"""The smallest kernel has some ten thousand; a file cut short by a full disk or a crash has fewer."""


def kept() -> Iterator[Finding]:
    """Whether kernels are kept for the next run, in whose folder, and how many there are."""
    from ..output.files import megabytes

    folder = cache.path
    if cache.trouble is not None:
        yield Finding("cache", NOTE, cache.trouble)
        return
    entries = [one for one in folder.iterdir() if ENTRY.fullmatch(one.name)]
    size = sum(one.lstat().st_size for one in entries)
    text = f"{folder}: {len(entries):,} kernels and modules, {megabytes(size)}"
    others = sharers(folder)
    broken = [one for one in entries if damaged(one)]
    if others:
        yield Finding(
            "cache", NOTE, f"{text}; {others}", f"chmod go-w {folder}, or point STRANDCLI_CACHE_DIR elsewhere"
        )
    elif broken:
        some = f"{len(broken)} damaged, such as {broken[0].name}"
        yield Finding("cache", NOTE, f"{text}; {some}", "nothing: they are compiled anew when they are needed")
    elif size > MOST_BYTES:
        yield Finding("cache", NOTE, text, "nothing: what was not used for longest is removed once a day")
    else:
        yield Finding("cache", OK, text + ("" if entries else "; the first run compiles, about a minute"))


def sharers(folder: Path) -> str:
    """Who else may write a folder whose files are run as code; "" where nobody may."""
    if not hasattr(os, "getuid"):
        return ""
    found = folder.stat()
    if found.st_uid not in (os.getuid(), 0):
        return "it belongs to another user"
    return "other users may write there" if found.st_mode & (stat.S_IWGRP | stat.S_IWOTH) else ""


def damaged(entry: Path) -> bool:
    """Whether a kernel's file clearly is none; a run looks closer, at a hash of its content."""
    if entry.suffix != ".kernel":
        return False
    try:
        if not entry.is_file() or entry.stat().st_size < LEAST_BYTES:
            return True
        with entry.open("rb") as file:
            return file.read(len(FIRST_BYTES)) != FIRST_BYTES
    except OSError:
        return True
