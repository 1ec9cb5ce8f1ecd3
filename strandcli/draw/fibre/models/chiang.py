"""Chiang et al. 2016, as path tracers have it, R, TT, TRT and the rest: `material.beta_m`, `beta_n`, `tilt`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ....scene.model import Material

name = "chiang"
NODES = 64 * 512
"""Of a table, at most."""


def tables(material: Material) -> Any:
    """`strandcli.draw.fibre.tables.FibreTables`, or None without highlights."""
    from ..chiang import build_tables

    return build_tables(material)


def columns(material: Material) -> Any:
    """Tables over the width, or None without highlights."""
    from ..chiang import columns

    return columns(material)


def memory(material: Material) -> int:
    """Bytes of the tables, at most."""
    return 0 if material.specular == 0 else NODES * 4 * (12 + 4)
