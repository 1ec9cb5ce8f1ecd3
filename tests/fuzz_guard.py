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
PLACES = {
    "os.mkdir": 1, "os.rmdir": 1, "os.remove": 1, "os.truncate": 1, "os.chmod": 1, "os.chown": 1, "os.utime": 1,
    "os.rename": 2, "os.link": 2, "shutil.rmtree": 1,
}  # fmt: skip
"""Events that change files, and how many paths they tell of."""
RELATIVE = frozenset(("os.mkdir", "os.rmdir", "os.remove", "os.rename", "os.link"))
"""Those that end with a descriptor for each path, -1 where it is relative to none."""
NEVER = frozenset(
    ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.fork", "os.forkpty", "socket.connect",
     "socket.bind", "pickle.find_class", "ctypes.dlopen", "webbrowser.open")
)  # fmt: skip
SINKS = ("/dev/null",)
OWN = {
    "pickle.find_class": (os.path.join("strandcli", "jit", "cache.py"),),
    "subprocess.Popen": (
        os.path.join("strandcli", "exchange", "usd", "process.py"), os.path.join("strandcli", "compiling", "service.py")
    ),
}  # fmt: skip
"""Files of the program that may do so: kernels are loaded after their hash was looked at (`attempt_kernel`); .usd is
read, and kernels are compiled, in processes of their own."""


class _Guard:
    """Where files may be written, and what was done besides; nothing is looked at while `allowed` is None."""

    def __init__(self) -> None:
        self.allowed: tuple[str, ...] | None = None
        self.done: list[str] = []
        self.hooked = False

    def outside(self, path: Any, folder: int = -1) -> bool:
        """Whether a path is in no such place; ``folder``: descriptor of what it is relative to, -1: none."""
        if isinstance(path, int):  # a file that is open already
            return False
        base = ""
        if folder >= 0:
            try:
                base = os.readlink(f"/proc/self/fd/{folder}")
            except OSError:  # not Linux: `shutil.rmtree`, which removes so, was looked at by itself
                return False
        place = os.path.realpath(os.path.join(base, os.fsdecode(path)))
        return place not in SINKS and not any(f"{place}/".startswith(f"{one}/") for one in self.allowed or ())

    def hear(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Note an event that must not be."""
        if self.allowed is None:
            return
        if event == "open":
            path, _, flags = arguments
            if isinstance(flags, int) and flags & WRITES and self.outside(path):
                self.done.append(f"{path} was opened to be written")
        elif event in NEVER:
            ours = _called_by(OWN.get(event, ()))
            systems = event == "ctypes.dlopen" and os.sep not in str(arguments[0])  # such as for Numba's threads
            if not (ours or systems):
                self.done.append(f"{event} {arguments!s:.80}")
        elif event in PLACES:
            paths, folders = arguments[: PLACES[event]], [one for one in arguments[PLACES[event] :] if one is not None]
            folders = [one for one in folders if isinstance(one, int)][-len(paths) :] if event in RELATIVE else []
            for path, folder in zip(paths, folders or [-1] * len(paths), strict=True):
                if self.outside(path, folder):
                    self.done.append(f"{event} {path}")


def _called_by(files: tuple[str, ...]) -> bool:
    """Whether one of these files of the program is among those that call."""
    frame = sys._getframe()
    while files and frame.f_back is not None:
        frame = frame.f_back
        if frame.f_code.co_filename.endswith(files):
            return True
    return False


GUARD = _Guard()


@contextmanager
def guarded(*folders: Path) -> Iterator[list[str]]:
    """Yield a list to which what must not be is added; files may be written in these folders alone."""
    if not GUARD.hooked:  # for good: a hook cannot be taken back
        sys.addaudithook(GUARD.hear)
        GUARD.hooked = True
    GUARD.done = []
    GUARD.allowed = tuple(os.path.realpath(folder) for folder in folders)
    try:
        yield GUARD.done
    finally:
        GUARD.allowed = None
