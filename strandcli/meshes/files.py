"""What a mesh file may name beside itself: files of its own folder, whose size is known before they are read."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
import numpy.typing as npt

from ..errors import StrandError
from ..exchange.bounded import opened
from ..picture_samples import FORMATS

LARGEST = 1 << 31
"""Bytes of a file that another one names, at most."""
PIXELS = 1 << 27
"""Of a texture, at most."""


class Beside:
    """Files beside a mesh file, as trimesh asks for them; nothing from elsewhere and nothing from the net."""

    def __init__(self, path: Path) -> None:
        self.folder = path.parent.resolve()
        self.file_name = path.name
        self.missing: list[str] = []
        self.pictures = 0

    def get(self, name: str) -> bytes:
        """What a file holds. Raises `ValueError` for one outside of the folder, `OSError` for none."""
        try:
            found = self._read(self._place(name))
        except (OSError, ValueError):
            self.missing.append(str(name)[:80])
            raise
        self.pictures += not str(name).lower().endswith((".mtl", ".bin"))
        return found

    __getitem__ = get

    def size(self, name: str) -> int:
        """Bytes of a file; 0 of none."""
        try:
            path = self._place(name)
            return path.stat().st_size if path.is_file() else 0
        except (OSError, ValueError):
            return 0

    @property
    def found(self) -> bool:
        """Whether a file was found that may be a picture."""
        return self.pictures > 0

    def _place(self, name: str) -> Path:
        path = (self.folder / unquote(str(name).strip()).replace("\\", "/")).resolve()
        if not path.is_relative_to(self.folder):
            raise ValueError("outside of the folder")
        return path

    def _read(self, path: Path) -> bytes:
        try:
            with opened(path, "file") as file:
                if file.size > LARGEST:
                    raise ValueError("too large")
                return file.take("content", file.size)
        except StrandError as error:
            raise OSError(str(error)) from None

    def keys(self) -> list[str]:
        """None: files are found by their names alone."""
        return []

    def namespaced(self, namespace: str) -> Beside:
        """The same folder."""
        return self

    def write(self, name: str, data: Any) -> None:
        """Nothing is written."""
        raise OSError("nothing is written")


def pixels(image: Any) -> npt.NDArray[np.uint8] | None:
    """A picture of Pillow's as (h, w, 3) uint8; None for one that is damaged or too large."""
    try:
        if image.width * image.height > PIXELS:
            return None
        return np.asarray(image.convert("RGB"))
    except MemoryError:
        raise
    except Exception:  # whatever a damaged picture raises
        return None


def picture(beside: Beside, name: str) -> npt.NDArray[np.uint8] | None:
    """A picture beside a mesh file; None where it cannot be read."""
    from PIL import Image

    try:
        return pixels(Image.open(io.BytesIO(beside.get(name)), formats=FORMATS))
    except Exception:  # likewise
        return None


def whole(path: Path, what: str) -> io.BytesIO:
    """What a file holds, to be read from memory."""
    with opened(path, what) as file:
        return io.BytesIO(file.take("content", file.size))
