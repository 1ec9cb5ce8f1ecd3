"""`.npy`, one array of numpy: (strands, points, 3), or with the width of each point as a fourth number."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import UsageError
from ...output.files import atomic
from ..bounded import amount, opened
from ..files import ReadOptions
from ..strands import Attribute, Source, Strands, TimeSample, even_offsets, without_short
from ..written import left_out, values_of
from .npz import DAMAGED, array_header

name = ".npy"
suffixes = (".npy",)

POINTS, WIDTH = "points", "width"


def sniff(head: bytes, size: int) -> bool:
    """Whether it begins as numpy's arrays do."""
    return head.startswith(np.lib.format.MAGIC_PREFIX)


def read(path: Path, options: ReadOptions) -> Strands:
    """The strands of a file; no object of Python is ever made of it."""
    with opened(path, ".npy file", options.lenient) as file:
        try:
            header = array_header(file.file)
        except DAMAGED:
            header = None
        if header is None:
            raise file.damaged("header: declares no array of numbers", 0)
        kind, shape, fortran = header
        begin = file.file.tell()
        file.seek("header", begin)
        if len(shape) != 3 or shape[1] < 1 or shape[2] not in (3, 4) or kind.kind != "f":
            raise file.fault(f"header: an array of {kind} of shape {shape}; strands are an array of floating-point "
                             "numbers of shape (strands, points, 3), or 4 with widths", 0)  # fmt: skip
        if math.prod(shape) * kind.itemsize != file.left:
            raise file.damaged(f"header: shape {shape} of {kind} needs {amount(math.prod(shape) * kind.itemsize)}, the "
                               f"file has {amount(file.left)} there", 0)  # fmt: skip
        values = file.array(POINTS, kind, shape[::-1] if fortran else shape)
        values = values.T if fortran else values
        with np.errstate(over="ignore", invalid="ignore"):
            points = np.ascontiguousarray(values[..., :3], np.float32).reshape(-1, 3)
            widths = np.ascontiguousarray(values[..., 3:], np.float32).reshape(-1)
        size = 0 if fortran else shape[2] * kind.itemsize
        file.finite(POINTS, points, lambda row: begin + size * row)
        file.finite(WIDTH, widths, lambda row: begin + 3 * kind.itemsize + size * row)
    attributes = {WIDTH: Attribute("point", widths)} if shape[2] == 4 else {}
    facts: dict[str, Any] = {"shape": list(shape), "type": str(kind)}
    return without_short(Strands(even_offsets(*shape[:2]), points, attributes, Source(name, facts=facts)))


def write(path: Path, strands: Strands, samples: Iterable[TimeSample] | None = None) -> list[str]:
    """Write the points, and widths beside them where there are any. Raises `UsageError` where strands differ in their
    number of points."""
    equal = strands.equal()
    if not equal and strands.count:
        raise UsageError(f"{path}: {name} needs strands of equally many points; make them so with --resample N")
    width = values_of(strands, WIDTH, 1)
    found = strands.points
    if width is not None:
        rows = np.broadcast_to(width.reshape(-1, 1), (found.shape[0], 1))
        found = np.concatenate([found, rows], axis=1)
    with atomic(path) as file:
        np.lib.format.write_array(file, found.reshape(strands.count, equal or 2, found.shape[1]), allow_pickle=False)
    return left_out(strands, name, (WIDTH,) if width is not None else ())
