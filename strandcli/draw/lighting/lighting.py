"""Shading of strands and solids in one exposure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...scene.model import DirectionalLight, Light
from ...solids import Solids
from ..common.kernels.light_columns import COLUMNS, LIGHT_SIZE, STRAND_WIDTH
from ..coverage.kernels.width_profiles import Profiles
from ..geometry.curves import Polylines
from ..shadows.shadow import ShadowMaps, map_arrays
from ..shadows.shadow_model import shades_vertices
from ..solids.solids import NONE, coats_of, paint_of
from ..view.camera import View, ball
from .kernels import inputs, shade_strands, shade_surfaces
from .kernels.mirror import DULL
from .kernels.occlusion import BOX_SIZE
from .occlusion import Occlusion
from .palette import Palette

if TYPE_CHECKING:
    from ...scene.model import Scene

NO_BOX = np.zeros(BOX_SIZE, np.float32)
NO_SPOTS = np.zeros((0, 2), np.float32)
"""Stands for pixels at their own positions."""
NOT_HIDDEN = np.zeros(0, np.uint8)
"""No pixel is hidden."""
NO_GRAIN = (np.zeros(0, np.float32), np.zeros(5, np.float32))


def given(array: NDArray[np.float32] | None, *shape: int) -> NDArray[np.float32]:
    """Return the array, or one without rows of this shape for None. Kernels test its length; with None, another type,
    they would be compiled again."""
    return np.zeros((0, *shape), np.float32) if array is None else array


def coating_of(solids: Sequence[Any], paint: NDArray[np.float32]) -> inputs.Coating:
    """Return the materials of visible solids; paint: from `paint_of`."""
    polished = any(solid.coat > 0 and solid.roughness < DULL for solid in solids)
    return inputs.Coating(paint, given(coats_of(solids), 7), given(None, 7), np.uint8(1) if polished else None)


ANY_TRIANGLE = np.zeros(0, np.int32)


@dataclass(frozen=True)
class Lighting:
    """Input of shading; members that a scene does not need are None."""

    scene: Scene
    palette: Palette
    sky: Any
    """See `strandcli.draw.lighting.environment.sky_of`."""
    view: View
    at: float
    """Time, seconds."""
    lights: NDArray[np.float32]
    """(n, `light_columns.COLUMNS`) from `strandcli.draw.lighting.lighting.pack_lights`."""
    maps: ShadowMaps | None
    occlusion: Occlusion | None
    solids: Solids | None
    """The visible solids, packed by `strandcli.solids.pack`."""
    grain: tuple[NDArray[np.float32], NDArray[np.float32]] | None = None
    """Levels and frame of `kernels.inputs.Screen`, if solids are dithered."""
    triangles: NDArray[np.int32] = field(default_factory=lambda: ANY_TRIANGLE)
    """(height * width,) or (0,): as in `kernels.inputs.Screen`."""
    like: Lighting | None = None
    """Lighting whose compiled kernels this one shares, if `sized` alone would tell them apart."""

    def without_light(self) -> Lighting:
        """Return the same lighting with all that shines taken away: solids are black, as opaque as they are."""
        scene = replace(self.scene, ambient=(0.0, 0.0, 0.0))
        return replace(
            self, scene=scene, sky=None, lights=self.lights[:0], maps=None, occlusion=None, grain=None, like=self
        )  # fmt: skip

    @property
    def fades(self) -> bool:
        """Whether some visible solid becomes transparent with distance."""
        return any(solid.visible and getattr(solid, "fade", 0) > 0 for solid in self.scene.solids)

    @property
    def skin(self) -> np.float32:
        """Depth below a solid's surface that counts as on it, metres: a hundredth of a strand's length."""
        return np.float32(0.01 * self.scene.emitter.length)

    @property
    def sized(self) -> np.uint8 | None:
        """1 if any light has a size and there are solids, else None, for which kernels compile without soft shadows."""
        if self.like is not None:
            return self.like.sized
        return np.uint8(1) if self.solids is not None and self.lights[:, LIGHT_SIZE].any() else None

    def shade_strands(
        self, lines: Polylines, marks: NDArray[np.uint8], tones: NDArray[np.float32],
        clear: NDArray[np.float32] | None, body: Profiles | None, colours: NDArray[np.float32],
    ) -> None:  # fmt: skip
        """Write the radiance at the vertices with non-zero ``marks`` (V,) to colours (V, 3); other rows are unchanged.

        tones (strands,); clear (lights, V): visibility of each light whose model shades vertices, or None; body:
        profiles of wide strands, or None.
        """
        p = self.palette
        shade_strands.strands(
            inputs.Vertices(
                lines.first, lines.world, given(lines.along), given(lines.tangents, 3), marks, tones, self.view.pack()
            ),
            inputs.StrandColour(p.colour, given(p.tint, 0, 6), p.diffuse), self._surround(), p.arrays, p.dual,
            self._lights(given(clear, 0)), map_arrays(self.maps), self.solids or NONE,
            None if body is None else inputs.WidthProfiles(body.slots, p.columns, body.profile), colours,
        )  # fmt: skip

    def shade_surfaces(
        self, keys: NDArray[np.uint64], image: NDArray[np.float32], spots: NDArray[np.float32] = NO_SPOTS,
        hidden: NDArray[np.uint8] = NOT_HIDDEN, rows: tuple[int, int] | None = None,
    ) -> None:  # fmt: skip
        """Composite the shaded solids of a z-buffer ``keys`` (height * width,) over image (height, width, 3).

        spots (pixels, 2): positions of the pixels on the screen; without rows each pixel is at its own position. hidden
        (height * width,): not 0 at pixels that are left as they are, as are those outside of the rows.
        """
        if self.solids is None:
            return
        top, bottom = rows or (0, len(image))
        seen = [solid for solid in self.scene.solids if solid.visible]
        paint = paint_of(seen, self.scene.emitter, self.at)
        shade_surfaces.surfaces(
            inputs.Screen(
                keys, self.view.pack(), spots, *(self.grain or NO_GRAIN), hidden, top, bottom,
                ANY_TRIANGLE if len(spots) else self.triangles,
            ),
            self._surround(),
            inputs.StrandLight(self.palette.colour, given(self.palette.loss, 4)),
            self._lights(given(None, 0)),
            map_arrays(self.maps), self.solids, coating_of(seen, paint), image,
        )  # fmt: skip

    def at_points(self) -> tuple[inputs.Lights, inputs.Lights]:
        """Return the lights for single points: of strands, which do not shade themselves, and of solids."""
        rows = self.lights.copy()
        rows[:, STRAND_WIDTH] = 0
        return self._lights(given(None, 0)), replace(self, lights=rows)._lights(given(None, 0))

    def _surround(self) -> inputs.Surround:
        found = self.occlusion
        around = (given(None, 4), NO_BOX) if found is None else (found.volume, found.box)
        return inputs.Surround(np.array(self.scene.ambient, np.float32), given(self.sky, 9, 3), *around)

    def _lights(self, clear: NDArray[np.float32]) -> inputs.Lights:
        return inputs.Lights(self.lights, clear, self.skin, self.sized)


def pack_lights(lights: tuple[Light, ...], maps: ShadowMaps | None, bounds: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return (n, `light_columns.COLUMNS`) float32, one row for each light that emits light."""
    rows: list[list[Any]] = []
    traced = 0
    for i, light in enumerate(lights):
        if light.intensity <= 0 or not any(light.colour):
            continue
        if isinstance(light, DirectionalLight):
            away = -np.array(light.direction, np.float64)
            where = away / np.linalg.norm(away)
        else:
            where = np.array(light.position)
        first, count = maps.owners[i] if maps is not None else (0, 0)
        bias = light.shadow.bias
        layers = maps.layers[first] if count and maps is not None else 0
        if count and maps is not None and bias == 0 and layers == 0:
            # an opacity map needs no bias: a strand's own contribution is subtracted
            bias = default_bias(maps.views[first], bounds)
        power = np.array(light.colour) * light.intensity
        kind = float(not isinstance(light, DirectionalLight))
        traced += shades_vertices(light)
        number = traced if shades_vertices(light) else 0
        width, over = (maps.thickness.mean, maps.over) if maps is not None else (0.0, 0.0)
        rows.append([kind, *where, *power, first, count, bias, layers, number, _size(light), width, over, 0.0])
    return np.array(rows, np.float32).reshape(-1, COLUMNS)


def default_bias(view: View, bounds: NDArray[np.float64]) -> float:
    """Return the depth bias of a min/max map, metres: the size of a texel at the groom's centre."""
    centre, radius = ball(bounds)
    depth = max(float(np.linalg.norm(centre - view.eye)), radius) if view.perspective else 1.0
    return depth / view.focal


def _size(light: Light) -> float:
    """Return the sine of a directional light's angular radius, or the radius of a point light in metres."""
    return math.sin(math.radians(light.size / 2)) if isinstance(light, DirectionalLight) else light.size / 2
