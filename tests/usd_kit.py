"""Files of USD written as text by hand, and made binary by Pixar's library."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

HEAD = """#usda 1.0
(
    defaultPrim = "hair"
    metersPerUnit = 0.01
    upAxis = "Z"
    timeCodesPerSecond = 30
)
"""


def tuples(values: Any) -> str:
    """Numbers as USD has them in brackets."""
    rows = np.asarray(values)
    if rows.ndim == 1:
        return f"[{', '.join(f'{one:.9g}' for one in rows.tolist())}]"
    return f"[{', '.join('(' + ', '.join(f'{one:.9g}' for one in row) + ')' for row in rows.tolist())}]"


def prim(strands: Sequence[Any], name: str = "hair", *, basis: str = "", wrap: str = "nonperiodic", more: str = "",
         points: str = "") -> str:  # fmt: skip
    """A prim of curves: linear, or cubic of a ``basis``; ``more``: lines of it; ``points``: another line of them."""
    kind = f'"cubic"\n    uniform token basis = "{basis}"' if basis else '"linear"'
    points = points or f"point3f[] points = {tuples(np.concatenate(strands))}"
    return (
        f'def BasisCurves "{name}"\n{{\n    uniform token type = {kind}\n    uniform token wrap = "{wrap}"\n'
        f"    int[] curveVertexCounts = [{', '.join(str(len(one)) for one in strands)}]\n    {points}\n{more}}}\n"
    )


def text(strands: Sequence[Any], *, basis: str = "", wrap: str = "nonperiodic", more: str = "") -> str:
    """A stage of one prim of curves with widths and colours."""
    points = sum(len(one) for one in strands)
    more += f'    float[] widths = {tuples(np.arange(points) / 64)} (\n        interpolation = "vertex"\n    )\n'
    more += f"    color3f[] primvars:displayColor = {tuples(np.arange(3 * len(strands)).reshape(-1, 3) / 64)} (\n"
    more += '        interpolation = "uniform"\n    )\n'
    return HEAD + prim(strands, basis=basis, wrap=wrap, more=more)


def moving(strands: Sequence[Any]) -> str:
    """A stage whose curves move, held by a transform that moves as well."""
    points = np.concatenate(strands)
    told = f"point3f[] points.timeSamples = {{\n 1: {tuples(points)},\n 3: {tuples(2 * points)},\n }}"
    body = prim(strands, points=told)
    return (
        HEAD + 'def Xform "world"\n{\n'
        "    double3 xformOp:translate.timeSamples = {\n 1: (1, 2, 3),\n 2: (2, 2, 3),\n }\n"
        '    uniform token[] xformOpOrder = ["xformOp:translate"]\n' + body + "}\n"
    )  # fmt: skip


def binary(content: str) -> bytes:
    """The same stage as Pixar's library writes it, packed."""
    from pxr import Sdf

    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "a.usda").write_text(content)
        layer = Sdf.Layer.FindOrOpen(str(Path(folder, "a.usda")))
        layer.Export(str(Path(folder, "b.usdc")))
        return Path(folder, "b.usdc").read_bytes()
