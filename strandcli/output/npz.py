"""Files of one array that say what they are of: NumPy reads them, and the comment of the archive has a fingerprint."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import numpy.typing as npt

from .files import atomic

MARK = b"strandcli of "


def write_array(path: Path, name: str, array: npt.NDArray[np.generic], of: str = "", packed: bool = False) -> None:
    """Write an array, whole or not at all, with the fingerprint that it is ``of``. Raises `RefusedError`."""
    kind = zipfile.ZIP_DEFLATED if packed else zipfile.ZIP_STORED
    with atomic(path) as file, zipfile.ZipFile(file, "w", kind, compresslevel=1) as archive:
        with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
            np.lib.format.write_array(member, np.ascontiguousarray(array), allow_pickle=False)
        if of:
            archive.comment = MARK + of.encode()


def made_of(archive: zipfile.ZipFile) -> str:
    """The fingerprint that an archive is of; empty where it has none."""
    comment = archive.comment
    return comment.removeprefix(MARK).decode("ascii", "replace") if comment.startswith(MARK) else ""
