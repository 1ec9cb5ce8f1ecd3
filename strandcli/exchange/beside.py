"""What a file may name beside itself: files of its own folder, whose size is known before they are read."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import unquote

import numpy as np
import numpy.typing as npt

from ..errors import StrandError
from ..files.picture_samples import pixels
from .bounded import Bounded, opened

LARGEST = 1 << 31
"""Bytes of a file that another one names, at most."""


class Beside:
    """Files beside a file, each read once; nothing from elsewhere and nothing from the net."""

    def __init__(self, path: Path) -> None:
        self.folder = path.parent.resolve()
        self.missing: list[str] = []
        self.unread: list[str] = []
        """Pictures that could not be read."""
        self._contents: dict[Path, bytearray] = {}

    def get(self, name: str) -> bytearray:
        """What a file holds. Raises `ValueError` for one outside of the folder, `OSError` for none."""
        try:
            path = (self.folder / unquote(name.strip()).replace("\\", "/")).resolve()
            if not path.is_relative_to(self.folder):
                raise ValueError("outside of the folder")
            if path not in self._contents:
                self._contents[path] = self._read(path)
            return self._contents[path]
        except (OSError, ValueError):
            self.missing.append(name[:80])
            raise

    def picture(self, name: str) -> npt.NDArray[np.uint8] | None:
        """The pixels (h, w, 3) of a picture; None where there is none that can be read."""
        try:
            found = picture(self.get(name))
        except (OSError, ValueError):
            return None
        if found is None:
            self.unread.append(name[:80])
        return found

    def _read(self, path: Path) -> bytearray:
        try:
            with opened(path, "file") as file:
                if file.size > LARGEST:
                    raise ValueError("too large")
                return _content(file)
        except StrandError as error:
            raise OSError(str(error)) from None

    @property
    def size(self) -> int:
        """Bytes of the files that were read."""
        return sum(map(len, self._contents.values()))


def picture(content: bytes | bytearray) -> npt.NDArray[np.uint8] | None:
    """The pixels (h, w, 3) of a picture's file; None where it cannot be read."""
    try:
        return pixels(bytes(content))
    except MemoryError:
        raise
    except Exception:  # whatever a damaged picture raises
        return None


def whole(path: Path, what: str) -> bytearray:
    """What a file holds; arrays of it can be written to."""
    with opened(path, what) as file:
        return _content(file)


def _content(file: Bounded) -> bytearray:
    found = bytearray(file.size)
    file.fill(memoryview(found))
    return found
