"""What reading must not do, whatever the file: write outside its folder, start a process, open a socket, unpickle.

Python tells of each by an audit event (PEP 578), in whatever library it happens.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
CHANGES = {
    "os.mkdir": 1, "os.rmdir": 1, "os.remove": 1, "os.truncate": 1, "os.chmod": 1, "os.chown": 1, "os.utime": 1,
    "os.rename": 2, "os.link": 2, "shutil.rmtree": 1,
}  # fmt: skip
"""Events that change files, and how many paths they tell of."""
RELATIVE = ("os.mkdir", "os.rmdir", "os.remove", "os.rename", "os.link")
"""Those that end with a descriptor for each path, -1 where it is relative to no open folder: so are names within
`shutil.rmtree` alone, which tells of itself."""
NEVER = frozenset(
    ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.fork", "os.forkpty", "socket.connect",
     "socket.bind", "pickle.find_class", "ctypes.dlopen", "webbrowser.open")
)  # fmt: skip
OWN = {
    "pickle.find_class": ("strandcli/jit/cache.py",),
    "subprocess.Popen": ("strandcli/exchange/usd/process.py", "strandcli/compiling/service.py"),
}
"""Files of the program that may do so: kernels are loaded after their hash was looked at; .usd is read, and kernels are
compiled, in processes of their own."""

_allowed: tuple[str, ...] | None = None
"""Folders in which files may be written; None: nothing is looked at."""
_done: list[str] = []


def _outside(path: Any) -> bool:
    """Whether a path is in no folder that is allowed."""
    if isinstance(path, int):  # a file that is open already
        return False
    place = os.path.realpath(os.fsdecode(path))
    return place != os.devnull and not any(f"{place}/".startswith(f"{one}/") for one in _allowed or ())


def _hear(event: str, arguments: tuple[Any, ...]) -> None:
    """Note an event that must not be."""
    if _allowed is None:
        return
    if event == "open":
        path, _, flags = arguments
        if isinstance(flags, int) and flags & WRITES and _outside(path):
            _done.append(f"{path} was opened to be written")
    elif event in NEVER:
        systems = event == "ctypes.dlopen" and os.sep not in str(arguments[0])  # such as for Numba's threads
        if not (systems or _called_by(OWN.get(event, ()))):
            _done.append(f"{event} {arguments!s:.80}")
    elif event in CHANGES:
        count = CHANGES[event]
        if not (event in RELATIVE and max(arguments[-count:]) >= 0):
            _done.extend(f"{event} {path}" for path in arguments[:count] if _outside(path))


def _called_by(files: tuple[str, ...]) -> bool:
    """Whether one of these files of the program is among those that call."""
    frame: Any = sys._getframe()
    while files and (frame := frame.f_back) is not None:
        if frame.f_code.co_filename.endswith(files):
            return True
    return False


_hooked: list[bool] = []


@contextmanager
def guarded(*folders: Path) -> Iterator[list[str]]:
    """Yield a list to which what must not be is added; files may be written in these folders alone."""
    global _allowed
    if not _hooked:  # for good: a hook cannot be taken back
        sys.addaudithook(_hear)
        _hooked.append(True)
    _done.clear()
    _allowed = tuple(os.path.realpath(folder) for folder in folders)
    try:
        yield _done
    finally:
        _allowed = None
