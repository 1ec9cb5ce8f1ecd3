"""Layers beside the picture (arbitrary output variables), exact where reconstruction from photographs estimates them.

Per pixel, by the nearest thing that any of its samples shows; through a pinhole at the frame's own time, whatever lens
and shutter do to the picture. Where strands are sorted, a sample shows the strand that most of its light comes from,
whatever stands before or behind it, as long as `LEAST` of the light comes from strands at all; else what a solid or the
background leaves there. Each is an array of the picture's height and width:

============= ========= =========================================================================================
`depth`       float32   metres along the camera's axis, not along the ray; infinite where nothing is
`mask`        float32   share of the pixel that strands cover before anything else, 0 to 1: of its samples, or where
                        strands are sorted of its light, exactly, however little that is
`tangent`     float32   (…, 3) unit vector in the world along the strand, root to tip; 0 where there is no strand
`orientation` float32   angle of the tangent as it is seen, radians in [0, π): 0 to the right, π / 2 upright,
                        counted against the clock; a line's, so root and tip are alike; −1 where there is no strand
`strand_id`   int32     index in the groom; −1 nothing, −2 a solid
`shadow`      float32   share of all lights' irradiance that strands and solids let through; 1 where nothing is
`linear`      float32   (…, 3) the picture itself as linear light, before exposure and tone curve
============= ========= =========================================================================================
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..coverage.coverage import Layer
from ..geometry.curves import Polylines
from ..lighting.lighting import Lighting
from ..shadows.shadow import map_arrays
from ..solids.solids import NONE
from ..view.camera import View
from .kernels import aovs as kernel

NOTHING = -1
SOLID = -2
LEAST = 1 / 64
"""Share of a sample's light: a tenth of a pixel wide strand that passes by a corner."""


class Recorder:
    """Gathers the layers of one frame while it is drawn: `strands` after each batch, then `rest`."""

    def __init__(self, image: Any, ids: NDArray[np.int32] | None) -> None:
        """``image``: the scene's settings; ``ids``: of each strand its place in the order of emission, where they do
        not stand in it."""
        self._names: tuple[str, ...] = image.aovs
        self._samples: int = image.supersample
        self._ids = ids
        width, height = image.drawn
        self._found: dict[str, NDArray[Any]] = {
            "strand_id": np.full((height, width), NOTHING, np.int32),
            "tangent": np.zeros((height, width, 3), np.float32),
            "orientation": np.full((height, width), -1, np.float32),
        }
        self._shares: NDArray[np.float32] | None = None

    def layer(
        self, layer: Layer, lines: Polylines, screen: NDArray[np.float32], keys: NDArray[np.uint64]
    ) -> None:
        """Note what a layer of sorted strands shows most into ``keys`` (samples · samples · height · width,), which
        hold the solids before; call `strands` after the last one."""
        if self._shares is None:
            self._shares = np.zeros(len(keys), np.float32)
        kernel.front(
            layer.fragments, len(lines.world), screen, np.float32(LEAST), keys, self._shares
        )

    def strands(
        self, lines: Polylines, screen: NDArray[np.float32], keys: NDArray[np.uint64], base: int, begin: int,
        view: View,
    ) -> None:  # fmt: skip
        """Note the strands of a batch, the first of which is strand ``begin``, that are in front in ``keys``
        (samples · samples · height · width,); their vertices are numbered from ``base``."""
        found = self._found
        kernel.strands(
            keys, self._samples, base, begin, kernel.SeenLines(lines.first, lines.world, screen), view.pack(),
            found["strand_id"], found["tangent"], found["orientation"],
        )  # fmt: skip

    def rest(self, keys: NDArray[np.uint64], lighting: Lighting) -> None:
        """What a finished z-buffer tells of depth, mask and solids, and the light that arrives there."""
        shape = self._found["strand_id"].shape
        depth, mask = np.empty(shape, np.float32), np.empty(shape, np.float32)
        point = np.empty((*shape, 3), np.float32)
        solids = lighting.solids or NONE
        kernel.depths(
            keys, self._shares, self._samples, lighting.view.pack(), solids, depth, mask, point,
            self._found["strand_id"],
        )  # fmt: skip
        self._found |= {"depth": depth, "mask": mask}
        if "shadow" in self._names:
            through = np.ones(shape, np.float32)
            kernel.shadows(
                self._found["strand_id"], keys, self._samples, point, lighting.lights, map_arrays(lighting.maps),
                solids, lighting.skin, lighting.sized, through,
            )  # fmt: skip
            self._found["shadow"] = through

    def layers(self, image: NDArray[np.float32]) -> dict[str, NDArray[Any]]:
        """The layers that were asked for; ``image`` is the linear picture in samples."""
        if self._ids is not None:
            ids = self._found["strand_id"]
            ids[ids >= 0] = self._ids[ids[ids >= 0]]
        if "linear" in self._names:
            height, width, _ = image.shape
            k = self._samples
            mean = image.reshape(height // k, k, width // k, k, 3).mean((1, 3), dtype=np.float32)
            self._found["linear"] = np.where(np.isfinite(mean), mean, np.float32(0))
        return {name: self._found[name] for name in self._names}
