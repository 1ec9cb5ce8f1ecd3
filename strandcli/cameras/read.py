"""Views from a file or a folder of any kind that is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ..errors import UsageError
from . import colmap, neus, own, transforms
from .lens import MissingSize
from .pinhole import Pinhole

KINDS = "transforms.json, a folder of COLMAP text files, cameras.npz of NeuS, or dataset.json of strandcli"
USD = (".usd", ".usda", ".usdc", ".usdz")
MOST = 1_000_000
"""Views of a file."""


@dataclass(frozen=True)
class Views:
    """What a file of cameras holds."""

    views: Sequence[Pinhole]
    own: bool
    """Whether strandcli wrote it: its world is a scene's, in metres. Else it is that of the file of strands."""
    notes: tuple[str, ...] = ()
    """What a person should know, a line each."""


def file_of(path: Path) -> Path:
    """The file of cameras that is meant by a folder, or the path itself. Raises `UsageError` where there is none."""
    if path.is_dir():
        found = _in_folder(path)
        if found is None:
            binary = next((path / part for part in colmap.FOLDERS if (path / part / "images.bin").is_file()), None)
            if binary is not None:
                raise UsageError(
                    f"{binary}: is binary; write text beside it: colmap model_converter --input_path {binary} "
                    f"--output_path {binary} --output_type TXT"
                )
            raise UsageError(f"{path}: holds no cameras that are known: {KINDS}")
        path = found
    if not path.exists():
        raise UsageError(f"{path}: no such file")
    return path


def views_of(
    path: Path, size: tuple[int, int] | None = None, assumed: tuple[int, int] | None = None
) -> Views:  # fmt: skip
    """The views of a file or a folder; ``size``: width and height, which the file may tell too if it agrees;
    ``assumed``: where it does not tell them. Raises `UsageError`, one line, for what cannot be read or drawn."""
    notes: list[str] = []
    path = file_of(path)
    try:
        views, ours = _read(path, size, notes)
    except MissingSize:
        if assumed is None:
            raise
        views, ours = _read(path, assumed, notes)
    if len(views) > MOST:
        raise UsageError(f"{path}: {len(views):,} views; {MOST:,} are read at the most")
    return Views(views, ours, tuple(dict.fromkeys(notes)))


def _read(path: Path, size: tuple[int, int] | None, notes: list[str]) -> tuple[Sequence[Pinhole], bool]:
    """The views of a file by its kind, and whether strandcli wrote it."""
    if path.name in colmap.FILES and colmap.folder_of(path.parent) is not None:
        return colmap.read(path.parent, size, notes)
    if path.suffix.lower() == ".npz":
        return neus.read(path, size, notes)
    if path.name == own.FILE:
        return own.read(path), True
    if path.suffix.lower() == ".json":
        return transforms.read(path, size, notes)
    if path.suffix.lower() in USD:
        raise UsageError(f"{path}: cameras of USD are not read; write them as transforms.json")
    raise UsageError(f"{path}: is no file of cameras that is known: {KINDS}")


def _in_folder(path: Path) -> Path | None:
    """The file of cameras in a folder, or the folder of COLMAP's files; the most exact first."""
    for name in (own.FILE, "transforms.json"):
        if (path / name).is_file():
            return path / name
    folder = colmap.folder_of(path)
    if folder is not None:
        return folder / colmap.FILES[0]
    return path / "cameras.npz" if (path / "cameras.npz").is_file() else None
