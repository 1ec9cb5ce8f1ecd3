"""Layers beside the picture (`strandcli.draw.film.aovs`) as files: ``depth_0001.npz`` with the array ``depth``,
exactly as it was drawn, and ``depth_0001.png`` to look at (`viewable`); with the extra `exr` also ``frame_0001.exr``
with all of them.

`linear` has no PNG of its own: the picture is that. In EXR depth is ``Z``, the linear picture ``R G B A``, whose ``A``
is 1 with a background, else what strands and solids cover, which ``R G B`` are multiplied by; tangents are
``tangent.X``, ``.Y``, ``.Z``, and the rest have their own names.
"""

from __future__ import annotations

import zipfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..common.extras import install
from ..errors import RefusedError, UsageError
from ..files.inputs import opened
from . import png
from .files import placed, write_pieces
from .state_file import made_of, write_array

Layers = Mapping[str, NDArray[Any]]

EXR_INTEGERS = 1 << 24
"""Strands that an EXR file can number: its floats hold whole numbers up to here."""
EXR_SCENE, EXR_LAYERS, EXR_HEAD = "strandcliScene", "strandcliLayers", 1 << 16
"""The attributes with the fingerprint of the scene and the names of layers, and bytes that a header has at most."""
_EXR_NAMES = {"depth": ("Z",), "linear": ("R", "G", "B", "A"), "tangent": ("tangent.X", "tangent.Y", "tangent.Z")}


def layer_files(frame: int, names: Sequence[str], exr: bool) -> list[str]:
    """The names of a frame's files beside its picture."""
    files = [f"{name}_{frame:04d}.npz" for name in names]
    files += [f"{name}_{frame:04d}.png" for name in names if name != "linear"]
    return files + ([f"frame_{frame:04d}.exr"] if exr else [])


def require_exr(strands: int) -> None:
    """Raise ``UsageError`` where EXR files cannot be written, or cannot number so many strands."""
    try:
        import OpenEXR

        found = hasattr(OpenEXR, "File")
    except ImportError:
        found = False
    if not found:
        raise UsageError(f"--exr: needs the package OpenEXR from 3.3 on; install it: {install('exr')}")
    if strands > EXR_INTEGERS:
        raise UsageError(f"--exr: its floats number at most {EXR_INTEGERS:,} strands; leave out --exr or use fewer")


def write_layers(directory: Path, frame: int, layers: Layers, exr: bool = False, scene: str = "") -> None:
    """Write a frame's layers, each file whole or not at all, with the fingerprint of their scene. Raises
    ``RefusedError`` where that fails."""
    for name, data in layers.items():
        write_array(directory / f"{name}_{frame:04d}.npz", name, data, scene, packed=True)
        if name != "linear":
            image, text = viewable(name, data)
            text |= {png.SCENE: scene} if scene else {}
            write_pieces(directory / f"{name}_{frame:04d}.png", png.encode(image, text))
    if exr:
        _write_exr(directory / f"frame_{frame:04d}.exr", layers, scene)


def is_of(path: Path, scene: str) -> bool:
    """Whether a picture or a layer's file is of the scene with this fingerprint."""
    if path.suffix == ".png":
        return png.keyword(path, png.SCENE) == scene
    try:
        with opened(path) as file:
            if path.suffix != ".npz":
                return scene.encode() in file.read(EXR_HEAD)
            with zipfile.ZipFile(file) as archive:
                return made_of(archive) == scene
    except (UsageError, RefusedError, OSError, zipfile.BadZipFile):
        return False


def is_whole(path: Path, names: Sequence[str]) -> bool:
    """Whether a layer's file is there with its end, and of EXR with these layers; of a PNG whether it is there."""
    try:
        with opened(path) as file:
            if path.suffix == ".npz":
                return zipfile.is_zipfile(file)
            head = file.read(EXR_HEAD) if path.suffix == ".exr" else b""
        return path.suffix != ".exr" or all(f" {name} ".encode() in head for name in names)
    except (UsageError, RefusedError, OSError):
        return False


def viewable(name: str, data: NDArray[Any]) -> tuple[NDArray[Any], dict[str, str]]:
    """A layer as pixels for PNG, (height, width) or (height, width, 3) of 8 or 16 bits, and text chunks for it."""
    if name == "depth":
        seen = np.isfinite(data)
        near, far = (float(data[seen].min()), float(data[seen].max())) if seen.any() else (0.0, 0.0)
        share = (far - data) / max(far - near, 1e-30)
        grey = np.where(seen, 1 + np.rint(65534 * np.where(seen, share, 0)), 0)
        return grey.astype(np.uint16), {"range": f"{near:.9g} {far:.9g}"} if seen.any() else {}
    if name == "tangent":
        return np.rint(np.clip(data + 1, 0, 2) / 2 * 65535).astype(np.uint16), {}
    if name == "orientation":
        shift = np.array([0.0, 1 / 3, 2 / 3]) * 2 * np.pi
        wheel = 0.5 + 0.5 * np.cos(2 * data[..., None] - shift)
        return np.rint(255 * np.where(data[..., None] < 0, 0, wheel)).astype(np.uint8), {}
    if name == "strand_id":
        mixed = (data.astype(np.uint32) + np.uint32(1)) * np.uint32(2654435761)  # Knuth's multiplicative hash
        colour = np.stack([mixed >> shift & np.uint32(0xFF) for shift in (24, 16, 8)], -1) // 4 * 3 + 64
        colour[data == -1], colour[data == -2] = 0, 40
        return colour.astype(np.uint8), {}
    return np.rint(65535 * np.clip(data, 0, 1)).astype(np.uint16), {}


def exr_channels(layers: Layers) -> Iterator[tuple[str, NDArray[np.float32]]]:
    """The channels of an EXR file by name, (height, width) float32 each."""
    for name, data in layers.items():
        if name == "linear" and data.shape[-1] == 3:
            data = np.dstack([data, np.ones(data.shape[:2], np.float32)])
        planes = np.moveaxis(data, -1, 0) if data.ndim == 3 else data[None]
        for channel, plane in zip(_EXR_NAMES.get(name, (name,)), planes, strict=True):
            yield channel, np.ascontiguousarray(plane, np.float32)


def _write_exr(path: Path, layers: Layers, scene: str) -> None:
    import OpenEXR

    header = {
        "compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, EXR_SCENE: scene,
        EXR_LAYERS: f" {' '.join(layers)} ",
    }  # fmt: skip
    try:
        with placed(path) as temporary:
            OpenEXR.File(header, dict(exr_channels(layers))).write(str(temporary))
    except RuntimeError as error:
        raise RefusedError(f"{path}: cannot be written: {' '.join(str(error).split())}") from error
