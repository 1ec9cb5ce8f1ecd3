"""The folder of compiled kernels: whether they can be kept and are run, how much there is, and what is damaged."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from ..common.counted import counted
from ..compiling.folder import ENTRY, MOST_BYTES, cache
from ..compiling.packs import Pack
from ..compiling.stores import writers
from ..output.files import megabytes
from . import NOTE, OK, Finding

FIRST_BYTES = b"strandcli kernel "
"""Of every kernel's file."""
LEAST_BYTES = 1000
"""The smallest kernel has some ten thousand; a file cut short by a full disk or a crash has fewer."""


def kept() -> Iterator[Finding]:
    """Whether kernels are kept for the next run, in a folder of this user's alone, how many there are, and which
    folders and packs are read beside it."""
    for words in cache.refused:
        yield Finding("cache", NOTE, words)
    if cache.keeps_nothing:
        yield Finding("cache", NOTE, cache.keeps_nothing)
    elif cache.trouble is None:
        yield _folder(cache.path)
    for store in cache.read_only:
        if isinstance(store, Pack):
            size = store.path.stat().st_size
            yield Finding("cache", OK, f"{store.path}: pack of {counted(len(store), 'kernel')}, {megabytes(size)}")
        else:
            yield _folder(store.path, writable=False)


def _folder(folder: Path, writable: bool = True) -> Finding:
    """What a folder has."""
    entries = [one for one in folder.iterdir() if ENTRY.fullmatch(one.name)]
    size = sum(one.lstat().st_size for one in entries)
    text = f"{folder}: {counted(len(entries), 'kernel or module', 'kernels and modules')}, {megabytes(size)}"
    broken = [one for one in entries if damaged(one, folder.stat())]
    if broken:
        some = f"{len(broken)} not used, such as {broken[0].name}: damaged, or writable for others"
        advice = "nothing: they are compiled anew when they are needed"
        if not writable:
            advice = "have who may write there remove them and run 'strandcli warmup PRESET'"
        return Finding("cache", NOTE, f"{text}; {some}", advice)
    if not writable:
        text += "; they are read, and cannot be written"
        advice = "nothing where all is there that is drawn; else have who may write there run 'strandcli warmup PRESET'"
        return Finding("cache", NOTE, text, advice)
    if size > MOST_BYTES:
        return Finding("cache", NOTE, text, "nothing: what was not used for longest is removed once a day")
    return Finding("cache", OK, text + ("" if entries else "; the first run compiles, about a minute"))


def damaged(entry: Path, folder: os.stat_result) -> bool:
    """Whether an entry is not used, for it clearly is none, or others than who owns its folder may change it; a run
    looks closer, at a hash of its content."""
    try:
        if writers(entry.lstat(), folder.st_uid):
            return True
        if entry.suffix != ".kernel":
            return False
        if not entry.is_file() or entry.stat().st_size < LEAST_BYTES:
            return True
        with entry.open("rb") as file:
            return file.read(len(FIRST_BYTES)) != FIRST_BYTES
    except OSError:
        return True
