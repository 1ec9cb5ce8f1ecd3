"""Light in one exposure: what falls on strands and on solids, and what they throw to the eye."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...solids import Solids
from ..coverage.kernels.width_profiles import Profiles
from ..geometry.curves import Polylines
from ..shadows.shadow import ShadowMaps, map_arrays
from ..solids.solids import NONE, coats_of, paint_of
from ..view.camera import View
from .kernels import shade_strands, shade_surfaces
from .kernels.inputs import Coating, Lights, Screen, StrandColour, StrandLight, Surround, Vertices, WidthProfiles
from .occlusion import Occlusion
from .palette import Palette

if TYPE_CHECKING:
    from ...scene.model import Scene

NO_BOX = np.zeros(10, np.float32)
NO_SPOTS = np.zeros((0, 2), np.float32)
"""The pixels of a picture lie where they belong."""


def given(array: NDArray[np.float32] | None, *shape: int) -> NDArray[np.float32]:
    """What a kernel asks the length of: it is compiled once, with and without, where None would be another type. Rows
    have this shape."""
    return np.zeros((0, *shape), np.float32) if array is None else array


@dataclass(frozen=True)
class Lighting:
    """What shading needs; None is what the scene does without."""

    scene: Scene
    palette: Palette
    sky: Any
    """See `strandcli.draw.lighting.environment.sky_of`."""
    view: View
    at: float
    """Seconds."""
    lights: NDArray[np.float32]
    """(n, 16) from `strandcli.draw.lighting.pack_lights.pack_lights`."""
    maps: ShadowMaps | None
    occlusion: Occlusion | None
    solids: Solids | None
    """Those that are seen, packed by `strandcli.solids.pack`."""

    @property
    def skin(self) -> np.float32:
        """Depth under a solid's surface that still counts as on it: a hundredth of a strand."""
        return np.float32(0.01 * self.scene.emitter.length)

    @property
    def sized(self) -> np.uint8 | None:
        """Whether any light has a size that solids show, as kernels are told: None compiles without such shadows."""
        return np.uint8(1) if self.solids is not None and self.lights[:, 12].any() else None

    def shade_strands(
        self, lines: Polylines, marks: NDArray[np.uint8], tones: NDArray[np.float32],
        clear: NDArray[np.float32] | None, body: Profiles | None, colours: NDArray[np.float32],
    ) -> None:  # fmt: skip
        """Into colours (V, 3): radiance at the vertices with ``marks`` (V,); the others are left as they are.

        tones (strands,); clear (lights, V): what strands leave of each light with exact shadows.
        """
        p = self.palette
        shade_strands.strands(
            Vertices(lines.first, lines.world, marks, tones, self.view.pack()),
            StrandColour(p.colour, given(p.tint, 0, 6), p.diffuse), self._surround(), p.arrays, p.dual,
            self._lights(given(clear, 0)), map_arrays(self.maps), self.solids or NONE,
            None if body is None else WidthProfiles(body.slots, p.columns, body.profile), colours,
        )  # fmt: skip

    def shade_surfaces(
        self, keys: NDArray[np.uint64], image: NDArray[np.float32], spots: NDArray[np.float32] = NO_SPOTS
    ) -> None:
        """Light the solids that ``keys`` (height * width,) shows, into image (height, width, 3).

        spots (pixels, 2): places on the screen, where pixels do not lie where they belong.
        """
        if self.solids is None:
            return
        seen = [solid for solid in self.scene.solids if solid.visible]
        paint = paint_of(seen, self.scene.emitter, self.at)
        shade_surfaces.surfaces(
            Screen(keys, self.view.pack(), spots), self._surround(),
            StrandLight(self.palette.colour, given(self.palette.loss, 3)), self._lights(given(None, 0)),
            map_arrays(self.maps), self.solids, Coating(paint, given(coats_of(seen), 4)), image,
        )  # fmt: skip

    def _surround(self) -> Surround:
        found = self.occlusion
        around = (given(None, 4), NO_BOX) if found is None else (found.volume, found.box)
        return Surround(np.array(self.scene.ambient, np.float32), given(self.sky, 9, 3), *around)

    def _lights(self, clear: NDArray[np.float32]) -> Lights:
        return Lights(self.lights, clear, self.skin, self.sized)
