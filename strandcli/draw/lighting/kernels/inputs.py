"""Inputs of the shading kernels: flat tuples of arrays."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

FADE, FADE_X, FADE_Y, FADE_Z = range(3, 7)
"""Columns of the paint of solids after their colour, metres: distance over which it fades, 0 for none; centre of the
fading."""


class Vertices(NamedTuple):
    """Vertices of strands, and the camera."""

    first: NDArray[np.int64]
    """(S + 1,) first vertex of each strand, and the number of vertices."""
    world: NDArray[np.float32]
    """(V, 3) metres."""
    along: NDArray[np.float32]
    """(V,) how far along its strand each vertex stands, 0 to 1; (0,): evenly."""
    tangents: NDArray[np.float32]
    """(V, 3) along the strand at each vertex, of any length; (0, 3): from the vertex before to that after."""
    marks: NDArray[np.uint8]
    """(V,) non-zero for vertices to shade."""
    tones: NDArray[np.float32]
    """(S,) tone of each strand in [−1, 1]."""
    camera: NDArray[np.float32]
    """(`view_columns.SIZE`,) packed camera."""


class StrandColour(NamedTuple):
    """Colours of strands."""

    colour: NDArray[np.float32]
    """(3,) colour of a mass of strands."""
    tint: NDArray[np.float32]
    """(A, B, 6) over the position along a strand and its tone: colour of a mass, and absorption minus that of the fibre
    model's tables, 1/radius; no rows if all strands have the same colour."""
    diffuse: Any
    """float32: scale of the diffuse term, 0 for none."""


class Surround(NamedTuple):
    """Ambient light and its occlusion."""

    ambient: NDArray[np.float32]
    """(3,) radiance."""
    sky: NDArray[np.float32]
    """(2, 9, 3) coefficients of `strandcli.draw.lighting.environment`; no rows without a picture."""
    volume: NDArray[np.float32]
    """(V, 4) cells of `strandcli.draw.lighting.occlusion`; no rows without occlusion."""
    box: NDArray[np.float32]
    """(`occlusion.BOX_SIZE`,) position and size of the cells."""


class Lights(NamedTuple):
    """Lights, and settings of the solids' shadows."""

    rows: NDArray[np.float32]
    """(n, `light_columns.COLUMNS`) one row for each light."""
    clear: NDArray[np.float32]
    """(m, V) visibility at each vertex of each light whose model shades vertices; no rows without such lights."""
    skin: Any
    """float32: depth below a solid's surface that counts as on it, metres."""
    sized: Any
    """uint8, or None if no light needs soft shadows of solids, which are then not compiled."""


class WidthProfiles(NamedTuple):
    """Light across strands that are wider than two pixels (`strandcli.draw.coverage.kernels.width_profiles`)."""

    slots: NDArray[np.int32]
    """(V,) number of each vertex's profile, or −1."""
    columns: Any
    """(n_θ, n_φ, COLUMNS, 8) float32 lobes of the fibre model in each column, or None."""
    profile: NDArray[np.float32]
    """(n, COLUMNS + 1, 3) out"""


class Screen(NamedTuple):
    """Pixels that show solids."""

    keys: NDArray[np.uint64]
    """(height * width,) z-buffer, as in `common.kernels.keys`."""
    camera: NDArray[np.float32]
    """(`view_columns.SIZE`,) packed camera."""
    spots: NDArray[np.float32]
    """(height * width, 2) position of each pixel on the screen; no rows if each is at its own position."""
    levels: NDArray[np.float32]
    """(n,) `strandcli.draw.film.film.level_sizes`; no rows: solids are not dithered."""
    frame: NDArray[np.float32]
    """(5,) columns of `strandcli.draw.solids.kernels.surface_pixels`."""
    hidden: NDArray[np.uint8]
    """(height * width,) not 0 at pixels that are left as they are; no rows: all are shaded."""
    begin: int
    end: int
    """The rows that are shaded: begin … end − 1, the rest are left as they are."""
    triangles: NDArray[np.int32]
    """(height * width,) the triangle that a pixel shows of a solid that consists of some, at which its look is looked
    for first; −1, or no rows: unknown."""


class Coating(NamedTuple):
    """Materials of solids, one row for each, in their order in `Solids`."""

    paint: NDArray[np.float32]
    """(m, 8) colour, then `FADE` and the centre of the fading, and an unused column."""
    coats: NDArray[np.float32]
    """(m, 7) columns of `strandcli.draw.solids.kernels.coat`; no rows without coats, patches and subsurface."""
    bare: NDArray[np.float32]
    """(0, 7) the coats of what a coat mirrors: none."""
    mirrors: Any
    """uint8, or None if no coat is so polished that it mirrors solids and strands, which is then not compiled."""


class StrandLight(NamedTuple):
    """Effect of strands on the light on solids."""

    bounce: NDArray[np.float32]
    """(3,) colour of a mass of strands."""
    loss: NDArray[np.float32]
    """(n, 4) from `strandcli.draw.fibre.dual.loss_table`; no rows where strands absorb all colours alike."""
