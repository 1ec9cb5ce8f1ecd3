"""Intrinsics of camera files as `Pinhole` takes them: square pixels and no distortion."""

from __future__ import annotations

import math
from pathlib import Path

from ..errors import UsageError

SEEN = 0.01
"""Pixels at the picture's rim under which two focal lengths are one."""


class MissingSize(UsageError):
    """A file of cameras does not tell the size of its pictures, and nobody else does."""


def square_focal(fx: float, fy: float, size: tuple[int, int], where: str, notes: list[str]) -> float:
    """The focal length, pixels, of a camera that has one for each axis. What the mean of two leaves at the rim of the
    picture is noted. Raises `UsageError` where either is no length."""
    if not (math.isfinite(fx) and math.isfinite(fy) and fx > 0 and fy > 0):
        raise UsageError(f"{where}: focal lengths {fx:g} and {fy:g}: both must be above 0")
    if fx == fy:
        return fx
    focal = 0.5 * (fx + fy)
    off = max(abs(fx - focal) / focal * size[0] / 2, abs(fy - focal) / focal * size[1] / 2)
    if off > SEEN:
        notes.append(f"{where}: focal lengths {fx:g} and {fy:g} are drawn as {focal:g}, {off:.2g} px off at the rim")
    return focal


def refuse_distortion(path: Path, where: str, numbers: dict[str, float]) -> None:
    """Raise `UsageError` where any of a lens's numbers, by name, is not 0."""
    bent = [f"{name} {value:g}" for name, value in numbers.items() if value != 0]
    if bent:
        raise UsageError(
            f"{path}: {where}: has lens distortion ({', '.join(bent)}), which strandcli does not draw; undistort the "
            "pictures and their cameras first (colmap image_undistorter)"
        )


def picture_size(
    width: float | None, height: float | None, given: tuple[int, int] | None, path: Path
) -> tuple[int, int]:
    """Width and height in pixels, of the file or as ``given``. Raises `UsageError` where there is neither or where they
    differ."""
    if width is None or height is None:
        if given is None:
            raise MissingSize(f"{path}: has no size of its pictures; add --size WxH")
        return given
    finite = math.isfinite(width) and math.isfinite(height)
    own = (int(width), int(height)) if finite else (0, 0)
    if own != (width, height) or min(own) < 1:
        raise UsageError(f"{path}: pictures of {width:g}x{height:g} pixels")
    if given is not None and given != own:
        raise UsageError(f"{path}: its cameras are of {own[0]}x{own[1]} pixels; leave out --size")
    return own
