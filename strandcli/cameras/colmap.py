"""COLMAP's text files: cameras.txt, images.txt, points3D.txt (colmap/colmap, doc/format.rst; of pixels
src/colmap/sensor/models.h).

Rotations are quaternions (w, x, y, z) from the world to a camera whose axes are right, down and forward; the corner of
the picture is (0, 0).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ..common.rotations import of_quaternion, quaternion_of
from ..errors import UsageError, one_line
from ..files.inputs import content
from .pinhole import Floats, Pinhole, in_order, picture_size, refuse_distortion, square_focal

FILES = ("cameras.txt", "images.txt")
FOLDERS = (".", "sparse/0", "sparse", "sparse_txt", "colmap/sparse_txt")
"""Where programs put them, in a folder of pictures."""
MARK = "strandcli"
"""In the first comment of files that strandcli wrote."""
MODELS = {
    "SIMPLE_PINHOLE": ("f", "cx", "cy"),
    "PINHOLE": ("fx", "fy", "cx", "cy"),
    "SIMPLE_RADIAL": ("f", "cx", "cy", "k"),
    "RADIAL": ("f", "cx", "cy", "k1", "k2"),
    "OPENCV": ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"),
    "FULL_OPENCV": ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"),
}
"""Parameters of the models that are pinholes where their distortion is 0."""
ID, MODEL, WIDTH, HEIGHT, PARAMETERS = range(5)
"""Columns of cameras.txt."""
QUATERNION, SHIFT, CAMERA, NAME = slice(1, 5), slice(5, 8), 8, 9
"""Columns of images.txt."""


def folder_of(path: Path) -> Path | None:
    """The folder with the text files, of that or of the folder of pictures about it."""
    for part in FOLDERS:
        if all((path / part / name).is_file() for name in FILES):
            return path / part
    return None


def read(folder: Path, size: tuple[int, int] | None, notes: list[str]) -> tuple[list[Pinhole], bool]:
    """The views by the names of their pictures, and whether strandcli wrote them. Raises `UsageError` for files that
    are damaged and for lenses that are no pinholes."""
    path = folder / "cameras.txt"
    lenses = {}
    for number, parts in rows(path):
        where = f"line {number}"
        try:
            model = parts[MODEL]
            if model not in MODELS:
                name = one_line(model)[:40]
                raise UsageError(f"{path}: {where}: model {name} is no pinhole; undistort the pictures first")
            values = [float(text) for text in parts[PARAMETERS:]]
            lens = dict(zip(MODELS[model], values, strict=True))
            shape = picture_size(float(parts[WIDTH]), float(parts[HEIGHT]), size, path)
            ident = int(parts[ID])
        except (IndexError, ValueError):
            raise UsageError(f"{path}: {where}: is no camera as COLMAP writes it") from None
        bent = {name: value for name, value in lens.items() if name[0] in "kp"}
        refuse_distortion(path, where, bent)
        fx, fy = lens.get("fx", lens.get("f", 0.0)), lens.get("fy", lens.get("f", 0.0))
        focal = square_focal(fx, fy, shape, f"{path}: {where}", notes)
        lenses[ident] = (shape, focal, (lens["cx"], lens["cy"]))
    path = folder / "images.txt"
    views = []
    lines = rows(path, keep_empty=True)
    for number, parts in lines:
        if not parts:
            continue
        next(lines, None)  # which has the points of the picture
        try:
            quaternion, shift = (np.array([float(text) for text in parts[part]]) for part in (QUATERNION, SHIFT))
            (width, height), focal, centre = lenses[int(parts[CAMERA])]
            name = " ".join(parts[NAME:])
            rotation = matrix_of(quaternion)
        except (IndexError, KeyError, ValueError):
            raise UsageError(f"{path}: line {number}: is no picture of a camera as COLMAP writes it") from None
        if not (np.isfinite(shift).all() and shift.shape == (3,) and name):
            raise UsageError(f"{path}: line {number}: is no picture of a camera as COLMAP writes it")
        views.append(Pinhole(Path(name).stem, width, height, focal, centre, rotation, -rotation.T @ shift))
    if not views:
        raise UsageError(f"{path}: has no picture")
    own = MARK.encode() in content(folder / "cameras.txt").partition(b"\n")[0]
    return in_order(views), own


def rows(path: Path, keep_empty: bool = False) -> Iterator[tuple[int, list[str]]]:
    """The number and the words of each line that is no comment."""
    text = content(path).decode("utf-8", "replace")
    for number, line in enumerate(text.splitlines(), 1):
        if not line.startswith("#") and (line.strip() or keep_empty):
            yield number, line.split()


def matrix_of(quaternion: Floats) -> Floats:
    """(3, 3) rotation of a quaternion (w, x, y, z) of any length. Raises `ValueError` for one of no length."""
    size = np.linalg.norm(quaternion)
    if quaternion.shape != (4,) or not np.isfinite(size) or size < 1e-6:
        raise ValueError("no quaternion")
    return of_quaternion(quaternion / size)


def written(views: Sequence[Pinhole], points: Floats, suffix: str = ".png") -> dict[str, bytes]:
    """The three files by name, of perspective views, and points (k, 3) to begin with.

    Views of one lens share a camera. The headers have as many lines as COLMAP's own, which other programs skip by
    number.
    """
    lenses: dict[tuple[int, int, float, tuple[float, float]], int] = {}
    images = []
    for number, view in enumerate(views, 1):
        lens = (view.width, view.height, view.focal, view.centre)
        ident = lenses.setdefault(lens, len(lenses) + 1)
        pose = [*quaternion_of(view.rotation), *(-view.rotation @ view.eye)]
        images.append(f"{number} {' '.join(repr(float(one)) for one in pose)} {ident} {view.name}{suffix}\n\n")
    cameras = [
        f"{ident} PINHOLE {width} {height} {' '.join(repr(float(one)) for one in (focal, focal, *centre))}\n"
        for (width, height, focal, centre), ident in lenses.items()
    ]
    cloud = [
        f"{number} {' '.join(f'{one:.7g}' for one in point)} 128 128 128 0\n" for number, point in enumerate(points, 1)
    ]
    heads = {
        "cameras.txt": f"# Cameras, a line each ({MARK}):\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
        f"# Number of cameras: {len(cameras)}\n",
        "images.txt": f"# Images, two lines each ({MARK}):\n#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
        f"#   POINTS2D[] as (X, Y, POINT3D_ID)\n# Number of images: {len(views)}\n",
        "points3D.txt": f"# Points, a line each ({MARK}):\n#   POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[]\n"
        f"# Number of points: {len(points)}\n",
    }
    bodies = {"cameras.txt": cameras, "images.txt": images, "points3D.txt": cloud}
    return {name: (head + "".join(bodies[name])).encode() for name, head in heads.items()}
