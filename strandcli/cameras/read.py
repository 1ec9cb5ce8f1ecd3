"""Views from a file or a folder of any kind that is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ..errors import UsageError
from . import colmap, neus, own, transforms
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


def views_of(path: Path, size: tuple[int, int] | None = None) -> Views:
    """The views of a file or a folder; ``size``: width and height where it does not tell them. Raises `UsageError`, one
    line, for what cannot be read or drawn."""
    notes: list[str] = []
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
    if path.is_dir():
        views, ours = colmap.read(path, size, notes)
    elif path.name in colmap.FILES and colmap.folder_of(path.parent) is not None:
        views, ours = colmap.read(path.parent, size, notes)
    elif path.suffix.lower() == ".npz":
        views, ours = neus.read(path, size, notes)
    elif path.name == own.FILE:
        views, ours = own.read(path), True
    elif path.suffix.lower() == ".json":
        views, ours = transforms.read(path, size, notes)
    elif path.suffix.lower() in USD:
        raise UsageError(f"{path}: cameras of USD are not read; write them as transforms.json")
    else:
        raise UsageError(f"{path}: is no file of cameras that is known: {KINDS}")
    if len(views) > MOST:
        raise UsageError(f"{path}: {len(views):,} views; {MOST:,} are read at the most")
    return Views(views, ours, tuple(dict.fromkeys(notes)))


def _in_folder(path: Path) -> Path | None:
    """The file of cameras in a folder, or the folder of COLMAP's files; the most exact first."""
    for name in (own.FILE, "transforms.json"):
        if (path / name).is_file():
            return path / name
    return colmap.folder_of(path) or (path / "cameras.npz" if (path / "cameras.npz").is_file() else None)
