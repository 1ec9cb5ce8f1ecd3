"""Marschner et al. 2003, R, TT and TRT lobes: `material.alpha`, `beta`, `azimuthal`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ....scene.model import Material

name = "marschner"
NODES = 48 * 192
"""Of a table, at most."""


def roughness(material: Material) -> float:
    """Chiang's β_n of the same azimuthal deviation."""
    from ..marschner import azimuthal_beta

    return azimuthal_beta(material.azimuthal)


def tables(material: Material) -> Any:
    """`strandcli.draw.fibre.tables.FibreTables`, or None without highlights."""
    from ..marschner import build_tables

    return build_tables(material)


def columns(material: Material) -> Any:
    """Tables over the width, or None without highlights."""
    from ..marschner import columns

    return columns(material)


def memory(material: Material) -> int:
    """Bytes of the tables, at most."""
    return 0 if material.specular == 0 else NODES * 4 * (8 + 2)
