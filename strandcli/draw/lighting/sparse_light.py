"""Solids behind sorted strands, with light at fewer places where it hardly varies (`kernels.lattice`)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..common.kernels.light_columns import LIGHT_SIZE, MAP_LAYERS
from ..common.scratch import Scratch
from .kernels import lattice as kernel
from .kernels.inputs import READ, WRITTEN
from .lighting import Lattice, Lighting


def is_costly(lighting: Lighting) -> bool:
    """Return whether light on solids takes so long that fewer places pay: it has soft edges."""
    return lighting.solids is not None and bool((lighting.lights[:, (MAP_LAYERS, LIGHT_SIZE)] > 0).any())


def shade_surfaces(
    lighting: Lighting, keys: NDArray[np.uint64], image: NDArray[np.float32], hidden: NDArray[np.uint8],
    rows: tuple[int, int], scratch: Scratch,
) -> None:  # fmt: skip
    """As `Lighting.shade_surfaces` of pixels at their own positions."""
    height, width = image.shape[:2]
    (top, bottom), count = rows, len(lighting.lights)
    settings = lighting.scene.image
    right, down = (np.uint8(settings.supersample * place % 4) for place in (settings.crop or (0, 0))[:2])
    frame = kernel.Frame(top, bottom, width, int(down), int(right))
    asked = scratch.borrow("asked_light", height * width, np.uint8)
    known = scratch.borrow("known_light", (height // 2 + 3, width // 2 + 3, count + int(kernel.ALL), 3), np.float32)
    camera = lighting.view.pack()
    kernel.ask(keys, hidden, frame, asked)
    written = Lattice(known, down, right, WRITTEN, kernel.COARSE)
    around = max(top - int(kernel.FAR), 0), min(bottom + int(kernel.FAR), height)
    lighting.shade_surfaces(keys, image, hidden=asked, rows=around, lattice=written)
    kernel.spread(keys, camera, frame, asked, known)
    around = max(top - 1, 0), min(bottom + 1, height)
    lighting.shade_surfaces(keys, image, hidden=asked, rows=around, lattice=written._replace(wanted=kernel.FINE))
    assert lighting.solids is not None
    kernel.smooth_blocks(keys, lighting.solids, asked, known, frame, hidden)
    kernel.choose(keys, camera, lighting.solids, asked, known, frame, hidden)
    lighting.shade_surfaces(keys, image, hidden=hidden, rows=rows)
    read = written._replace(use=READ, wanted=kernel.BETWEEN)
    lighting.shade_surfaces(keys, image, hidden=hidden, rows=rows, lattice=read)
    here = hidden[top * width : bottom * width]
    if (here == kernel.SMOOTH).any():
        lighting.shade_smooth(keys, image, hidden, rows, written)
    here &= kernel.HIDDEN  # `BETWEEN` and `SMOOTH` become `DRAWN`
