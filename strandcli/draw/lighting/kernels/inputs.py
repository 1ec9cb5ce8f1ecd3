"""What the shading kernels are given: flat tuples of arrays, as kernels can take them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray


class Vertices(NamedTuple):
    """Strands that are shaded, and from where they are seen."""

    first: NDArray[np.int64]
    """(S + 1,) first vertex of each strand, and one more than the last."""
    world: NDArray[np.float32]
    """(V, 3) metres."""
    marks: NDArray[np.uint8]
    """(V,) 1 for vertices that are shaded."""
    tones: NDArray[np.float32]
    """(S,) in [−1, 1]."""
    camera: NDArray[np.float32]
    """(`view_columns.SIZE`,) packed camera."""


class StrandColour(NamedTuple):
    """Colours of strands."""

    colour: NDArray[np.float32]
    """(3,) of a mass of strands."""
    tint: NDArray[np.float32]
    """(A, B, 6) over the place along a strand and its tone: colour of a mass, and absorption beyond that of the fibre
    model's tables, 1/radius; no rows where all strands have one colour."""
    diffuse: Any
    """float32: scale of the diffuse term, 0 for none."""


class Surround(NamedTuple):
    """Light from everywhere, and what of it is seen."""

    ambient: NDArray[np.float32]
    """(3,) radiance."""
    sky: NDArray[np.float32]
    """(2, 9, 3) coefficients of `strandcli.draw.lighting.environment`; no rows without a picture."""
    volume: NDArray[np.float32]
    """(V, 4) cells of `strandcli.draw.lighting.occlusion`; no rows without occlusion."""
    box: NDArray[np.float32]
    """(`occlusion.BOX_SIZE`,) the place of the cells."""


class Lights(NamedTuple):
    """Lights, and how solids hide them."""

    rows: NDArray[np.float32]
    """(n, `light_columns.COLUMNS`) a row a light."""
    clear: NDArray[np.float32]
    """(m, V) what strands leave of each light with exact shadows at each vertex; no rows where no light has them."""
    skin: Any
    """float32: depth under a solid's surface that counts as on it, metres."""
    sized: Any
    """uint8, or None where no light has a size that solids show: then soft shadows are not compiled."""


class WidthProfiles(NamedTuple):
    """Light across strands that are wider than two pixels (`strandcli.draw.coverage.width_profiles`)."""

    slots: NDArray[np.int32]
    """(V,) number of each vertex' profile, or −1."""
    columns: Any
    """(n_θ, n_φ, COLUMNS, 8) lobes of the fibre model in each column, float32; None where it has none."""
    profile: NDArray[np.float32]
    """(1 + m, n, COLUMNS + 1, 3) what is written: of light without exact shadows, and of each light with them."""


class Screen(NamedTuple):
    """Pixels that show solids."""

    keys: NDArray[np.uint64]
    """(height * width,) what is nearest in each pixel, as in `common.kernels.keys`."""
    camera: NDArray[np.float32]
    """(`view_columns.SIZE`,) packed camera."""
    spots: NDArray[np.float32]
    """(height * width, 2) where on the screen each of these pixels lies; no rows where at its own place."""


class Coating(NamedTuple):
    """What solids look like, a row a solid, in their order in `Solids`."""

    paint: NDArray[np.float32]
    """(m, 8) colour, distance over which it fades (0: none), centre of the fading, unused."""
    coats: NDArray[np.float32]
    """(m, 4) as in `strandcli.draw.solids.kernels.coat`; no rows where all solids are matt and even."""


class StrandLight(NamedTuple):
    """What strands do to light on solids."""

    bounce: NDArray[np.float32]
    """(3,) colour of a mass of strands."""
    loss: NDArray[np.float32]
    """(n, 3) of `strandcli.draw.fibre.dual.loss_table`; no rows where strands shade in grey."""
