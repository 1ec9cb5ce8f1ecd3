"""Shadow maps of all lights that have one: min/max maps, and deep opacity maps.

The distance between strands (`spacing`) sets the resolution of an opacity map. A texel much finer than that contains
one strand or none, so it shades points behind it fully or not at all, where it should shade all of them partly; a texel
much coarser blurs the groom's outline. `strandcli study PRESET --axis shadow` measured `TEXEL` strand spacings to be
best.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ...errors import RefusedError
from ...scene.model import DirectionalLight, Light
from ..common.kernels.view_columns import SIZE
from ..common.scratch import Scratch
from ..geometry.curves import Polylines
from ..geometry.extent import Thickness
from ..view.camera import View, ball, parallel_view, point_views
from ..zbuffer.raster import bands_of, to_screen
from .kernels import cell_extents, opacity, opacity_maps, splats
from .kernels import minmax as kernel
from .kernels.map_parts import PartsInMap
from .kernels.strand_shadows import ShadowArrays
from .shadow_model import casts_map, model_of
from .strands_in_map import NO_EXTENTS, coarse, parts_in_map, view_numbers

TEXEL = 1.5
"""Side of an opacity map's texel, in strand spacings."""
LONE = 4.0
"""Side of a texel in strand widths, for a groom of a single strand. `opacity` subtracts a strand's own contribution
as its mean over all positions among the texels; the error is up to an eighth of width / texel. With texels one width
wide the strand shaded itself by 2.2 % (mean) and 16 % (maximum); with this value by .06 % and 2.8 %."""
FALL = 9.0
"""h of `kernels.opacity`, as a multiple of the length over which light falls to 1 / e among strands `spacing` apart.
It is greater than 1 because single strands lie in front of the rest."""
PLACES = 2**31 - 1
"""Greatest length of an opacity map in numbers: `simd.gather` takes 32-bit indices."""
LEAST_FALL = 1 / 50
"""Least h, as a share of the groom's size. Stray hairs may lie centimetres in front of a bundle in which light falls
off within a millimetre; with a smaller h the layers would be coarse where the bundle begins."""
STEEPEST = 4.0
"""Texels of depth by which strands in the cells about a cell widen its extents. What is farther before it, a stray
hair, stays in its own cells: soft shadows on solids are as wide as cells say that strands are far away."""
EMPTY_TEXEL = np.array([np.inf, -np.inf], np.float32).view(np.uint64)[0]  # one number: filled in one pass
TINY = 1e-9
NO_MAPS = np.zeros(0, np.int64)
NO_SHADOWS = ShadowArrays(
    np.zeros((0, 2), np.float32), np.zeros(0, np.float32), NO_MAPS, NO_MAPS, np.zeros((0, SIZE), np.float32)
)
"""Arrays of scenes without maps. They are empty arrays, not None, because kernels would be compiled again for None."""
NO_THICKNESS = Thickness()


@dataclass
class ShadowMaps:
    """All maps, as `kernels.minmax.transmittance` and `kernels.opacity.optical_depth` read them."""

    views: list[View]
    packed: NDArray[np.float32]
    """(M, `view_columns.SIZE`) the views packed."""
    starts: NDArray[np.int64]
    """(M,) first row in `texels` of each min/max map; index in `stacks` of each opacity map, set by `divide`."""
    sizes: NDArray[np.int64]
    texels: NDArray[np.float32] | None
    """(T, 2) nearest and farthest depth, metres; None where all are opacity maps."""
    owners: list[tuple[int, int]]
    """For each light: index of its first map, and number of its maps."""
    stacks: NDArray[np.float32] | None = None
    """(K,) all opacity maps; None before `divide` and where there are none."""
    layers: list[int] = field(default_factory=list)
    """Number of layers of each map, 0 for a min/max map."""
    extents: list[NDArray[np.float32]] = field(default_factory=list)
    """For each map (n, 2) nearest and farthest depth, metres, of each texel, or of each cell of an opacity map."""
    thickness: Thickness = NO_THICKNESS
    over: float = 1.0
    """1 / h of `kernels.opacity`, 1/m."""
    chances: NDArray[np.float32] | None = None
    """(strands,) from `chances_of`, to leave out most strands deep in shadow; None: none are."""
    heads: dict[int, NDArray[np.float32]] = field(default_factory=dict)
    """Of each opacity map that is divided, `OpacityMap.heads`."""
    _lengths: list[int] = field(default_factory=list)
    """Numbers of each opacity map that is divided."""

    @property
    def deep(self) -> bool:
        """Whether there are opacity maps, into whose layers strands must be drawn in a second pass."""
        return any(self.layers)

    def build(self, lines: Polylines, workers: int, scratch: Scratch) -> None:
        """Draw polylines that contain every strand, one map after the other."""
        for number, layers in enumerate(self.layers):
            if not layers:
                self._fill(number, lines, workers, scratch)
                continue
            parts = self.parts(number, lines, workers, scratch, self.extents[number])
            self._divide(number, scratch)
            self._draw(number, parts)
            scratch.release(f"map_heads_{number}")
            opacity_maps.sum_layers(len(self.extents[number]), layers, self._stack(number))

    def add(self, lines: Polylines, workers: int, scratch: Scratch, again: bool = False) -> None:
        """Draw a portion of the polylines into every map; ``again``: into the layers of opacity maps, once `divide` has
        made these."""
        for number, layers in enumerate(self.layers):
            if again and layers:
                self._draw(number, self.parts(number, lines, workers, scratch))
            elif layers:
                self.parts(number, lines, workers, scratch, self.extents[number])
            elif not again:
                self._fill(number, lines, workers, scratch)

    def divide(self, scratch: Scratch) -> None:
        """Make empty layers in every opacity map. Call it after all portions have been added."""
        for number, layers in enumerate(self.layers):
            if layers:
                self._divide(number, scratch)

    def finish(self) -> None:
        """Sum the layers of every opacity map. Call it after all portions have been drawn into them."""
        for number, layers in enumerate(self.layers):
            if layers:
                opacity_maps.sum_layers(len(self.extents[number]), layers, self._stack(number))

    def _divide(self, number: int, scratch: Scratch) -> None:
        """Make empty layers between the nearest and farthest depth of each cell of an opacity map. Raises
        `RefusedError` if it would be too large."""
        layers, extents = self.layers[number], self.extents[number]
        texel = texel_of(self.views[number])
        side = int(self.sizes[number]) // 2
        around = scratch.borrow("spread_extents", cell_extents.room_of(side), np.float32)
        cell_extents.spread(extents, side, np.float32(STEEPEST * texel), around)
        rows = scratch.borrow("rows_of_cells", len(extents), np.float32)
        length = opacity.numbers_of(len(rows), opacity_maps.number_cells(extents, rows), layers)
        if length > PLACES:
            raise RefusedError(
                f"shadow: an opacity map would hold {4 * length / 1e9:.1f} GB, more than the "
                f"{4 * PLACES / 1e9:.1f} GB that a kernel counts; a smaller shadow.size or fewer layers take less"
            )
        self.starts[number] = begin = sum(self._lengths)
        self._lengths.append(length)
        maps = int(np.count_nonzero(self.layers))
        likely = (begin + length) * maps // len(self._lengths)
        self.stacks = scratch.extend("stacks", begin + length, np.float32, begin, likely)
        over = np.float32(self.over)
        self.heads[number] = heads = scratch.borrow(f"map_heads_{number}", (len(extents), 4), np.float32)
        opacity_maps.divide(extents, layers, np.float32(texel), over, rows, self.stacks[begin:], heads)

    def _stack(self, number: int) -> NDArray[np.float32] | None:
        """Return an opacity map, None before it is divided."""
        place = int(np.count_nonzero(self.layers[:number]))
        if self.stacks is None or place >= len(self._lengths):
            return None
        return self.stacks[self.starts[number] :][: self._lengths[place]]

    def parts(
        self, number: int, lines: Polylines, workers: int, scratch: Scratch, extents: NDArray[np.float32] = NO_EXTENTS
    ) -> PartsInMap:
        """Return what polylines draw into an opacity map, valid until the next are requested; widen its extents if they
        are given."""
        view, size = self.views[number], int(self.sizes[number])
        return parts_in_map(
            lines, self.thickness, view, size, workers, scratch, self.over, self.chances, extents
        )  # fmt: skip

    def _draw(self, number: int, parts: PartsInMap) -> None:
        """Add parts to the layers of an opacity map."""
        over, layers = np.float32(self.over), self.layers[number]
        opacity_map = splats.OpacityMap(self.heads[number], over, layers, self._stack(number))
        opacity_maps.draw(parts, int(self.sizes[number]), view_numbers(self.views[number]), opacity_map)

    def _fill(self, number: int, lines: Polylines, workers: int, scratch: Scratch) -> None:
        """Draw into a min/max map."""
        view, size = self.views[number], int(self.sizes[number])
        lines = coarse(lines, view, scratch)
        screen = to_screen(lines, view, scratch, "light_screen")
        bands = bands_of(lines.first, screen, None, (size, size), workers, scratch)
        seen = view_numbers(view)
        kernel.fill(
            lines.first, screen, bands, size, seen.far, seen.near, self.extents[number],
        )  # fmt: skip


def plan_maps(
    lights: tuple[Light, ...],
    bounds: NDArray[np.float64],
    scratch: Scratch,
    thickness: Thickness = NO_THICKNESS,
    spacing: float = 0.0,
    counted: bool = True,
) -> ShadowMaps | None:
    """Return empty maps of the lights that need them, fitted to the box ``bounds`` (2, 3), metres, or None.

    ``spacing``: metres between neighbouring strands, sets the texel size of opacity maps; ``counted``: see
    `ShadowModel.casts_map`.
    """
    views: list[View] = []
    layers: list[int] = []
    owners = []
    for light in lights:
        before = len(views)
        if casts_map(light, counted):
            count = model_of(light).layers(light.shadow)
            found = _views_of(light, count > 0, bounds, thickness, spacing)
            views += found
            layers += [count] * len(found)
        owners.append((before, len(views) - before))
    if not views:
        return None
    sizes = np.array([view.width for view in views], np.int64)
    deep = np.array(layers) > 0
    begin, texels, extents = allocate_extents(sizes, deep, scratch)
    packed = np.stack([view.pack() for view in views])
    over = 1.0 / max(_fall_length(bounds, thickness, spacing), TINY)
    return ShadowMaps(views, packed, begin, sizes, texels, owners, None, layers, extents, thickness, over)


def allocate_extents(
    sizes: NDArray[np.int64], deep: NDArray[np.bool_], scratch: Scratch
) -> tuple[NDArray[np.int64], NDArray[np.float32] | None, list[NDArray[np.float32]]]:
    """Allocate empty extents of all maps; return `starts`, `texels` and `extents` of `ShadowMaps`."""
    counts = np.where(deep, sizes**2 // opacity.TEXELS, sizes**2)
    begin = np.concatenate([[0], np.cumsum(np.where(deep, 0, counts))]).astype(np.int64)
    every = scratch.borrow("texels", (int(counts.sum()), 2), np.float32)
    every.view(np.uint64).fill(EMPTY_TEXEL)
    extents = [every] * len(sizes)
    at = 0
    for number in np.argsort(deep, kind="stable"):  # min/max maps first, so that their texels are one array
        extents[number] = every[at : at + counts[number]]
        at += int(counts[number])
    return begin[:-1], None if deep.all() else every[: int(begin[-1])], extents


def _views_of(
    light: Light, deep: bool, bounds: NDArray[np.float64], thickness: Thickness, spacing: float
) -> list[View]:
    """Return the views of a light's maps; ``deep``: for opacity maps, whose texel size follows the strand spacing."""
    size = model_of(light).side_of(light.shadow)
    if not deep:
        return light_views(light, size, bounds)
    size = max(size + size % 2, 4)  # an even number, at least two cells of 2×2 texels for interpolation
    apart = max(TEXEL * spacing, thickness.width) if spacing > 0 else LONE * thickness.width
    return _coarser(light, size, bounds, light_views(light, size, bounds), light.shadow.texel or apart)


def _fall_length(bounds: NDArray[np.float64], thickness: Thickness, spacing: float) -> float:
    """Return h of `kernels.opacity`, metres."""
    diagonal = float(np.linalg.norm(bounds[1] - bounds[0]))
    dense = spacing > 0 < thickness.mean
    return max(FALL * spacing**2 / thickness.mean, LEAST_FALL * diagonal) if dense else diagonal


def light_views(light: Light, size: int, bounds: NDArray[np.float64]) -> list[View]:
    """Return the views of a light that cover the box ``bounds``, ``size`` texels a side."""
    if isinstance(light, DirectionalLight):
        return [parallel_view(light.direction, size, bounds)]
    return point_views(light.position, size, bounds)


def _coarser(light: Light, size: int, bounds: NDArray[np.float64], views: list[View], wanted: float) -> list[View]:
    """Return the light's views with texels of ``wanted`` metres at the groom's centre, at most ``size`` a side."""
    texel = max(texel_of(view, bounds) for view in views)
    if texel >= wanted:
        return views
    # the focal length is adjusted after rounding to whole cells, so that maps do not jump as the texel count changes
    views = light_views(light, 2 * max(math.ceil(size * texel / wanted / 2), 4), bounds)
    wider = max(wanted / max(texel_of(view, bounds) for view in views), 1.0)
    return [replace(view, focal=view.focal / wider) for view in views]


def texel_of(view: View, bounds: NDArray[np.float64] | None = None) -> float:
    """Return the size of a texel, metres, at the centre of ``bounds``, or at the view's middle depth without them."""
    if not view.perspective:
        return 1.0 / view.focal
    if bounds is None:
        return 0.5 * (view.near + view.far) / view.focal
    centre, radius = ball(bounds)
    return max(float(np.linalg.norm(centre - view.eye)), radius) / view.focal


def map_arrays(maps: ShadowMaps | None) -> ShadowArrays:
    """Return the arrays that kernels read, with empty arrays where there are no maps."""
    if maps is None:
        return NO_SHADOWS
    texels = NO_SHADOWS.texels if maps.texels is None else maps.texels
    stacks = NO_SHADOWS.stacks if maps.stacks is None else maps.stacks
    return ShadowArrays(texels, stacks, maps.starts, maps.sizes, maps.packed)
