"""One frame, stage by stage: curves, shadow maps, visibility, light on what is seen, film.

What is not seen is never shaded: either the z-buffer is filled first and holds, for each sample, the segment in front;
or fragments are sorted first, and those that too much stands before are left out. Into a z-buffer strands go in
portions, so that memory stays bounded however many there are.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..constants import PORTION, W
from ..groom.children import Children
from ..groom.emit import Groom
from ..plan import needs_counts
from . import lens, occlusion, raster
from .aovs import Recorder
from .body import Body, body_of
from .camera import View, camera_view
from .coverage import Coverage
from .curves import Polylines, flatten, greatest_pieces
from .detail import Level, level_of, needed
from .edges import find_edges
from .environment import sky_of
from .extent import bounds_of, thickness_of, widths_of
from .film import curve_of, dithered, gradient
from .kernels import detail, film, shade_strands, shade_surfaces, solids
from .scratch import Scratch
from .shading import Palette, pack_lights
from .shadow import ShadowMaps, Thickness, is_traced, plan_maps, strand_spacing, wants_map
from .solids import frames_of, paint_of
from .solids import packed as pack_solids
from .traced import Grid, grid_of

NO_SPOTS = np.zeros((0, 2), np.float32)
"""The pixels of a picture lie where they belong."""


@dataclass
class Drawing:
    """One picture with what it took."""

    image: NDArray[np.uint8]
    """(height, width, 3) sRGB."""
    seconds: dict[str, float] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    curve_px_max: float | None = None
    aovs: dict[str, NDArray[Any]] = field(default_factory=dict)
    """Layers that the scene asks for, by name (see `strandcli.draw.aovs`)."""


class Renderer:
    """Draws frames of one scene; holds what stays the same from frame to frame."""

    def __init__(
        self, scene: Any, groom: Groom, before: Callable[[str], None] = lambda part: None,
        children: Children | None = None,
    ) -> None:  # fmt: skip
        """``before`` is called in each frame ahead of its "coverage", where strands are sorted, and of its "light";
        ``children``: of this scene and groom, where somebody has them already."""
        self.scene = scene
        self._before = before
        self.tones = groom.tones
        self.scratch = Scratch()
        deep = any(light.shadow.model in ("opacity", "traced") and wants_map(light) for light in scene.lights)
        if children is None and scene.children is not None:
            children = Children(scene, groom)
        self.children = children
        self._spacing = strand_spacing(groom.roots) * math.sqrt(groom.strands / self._most(groom)) if deep else 0.0
        self.sky = sky_of(scene)
        self._occlusion: occlusion.Occlusion | None = None
        """Of the exposure that is drawn."""
        self.palette = Palette(scene.material, deep)
        self.ids: NDArray[np.int32] | None = None
        """Of each strand its index in the groom, where some are left out."""
        self.size = (scene.image.drawn[0] * scene.image.supersample, scene.image.drawn[1] * scene.image.supersample)
        self.visible = [solid for solid in scene.solids if solid.visible]
        self._traced = [light for light in scene.lights if is_traced(light)]
        self._counts = needs_counts(scene)
        nearest = scene.image.nearest if scene.image.resolver == "kbuffer" else None
        self.coverage = (
            None if scene.image.resolver == "zbuffer" else Coverage(self.size, scene.material.opacity, nearest)
        )
        self._rounds = scene.material.rounded
        # what cannot become thinner, a line a pixel wide or in a min/max map, becomes shorter where it fades
        self._thins = self.coverage is not None and not any(
            light.shadow.model == "minmax" and wants_map(light) for light in scene.lights
        )
        self._clock = 0.0
        self._seen = 0
        top = np.array(scene.image.background, np.float32)
        bottom = top if scene.image.horizon is None else np.array(scene.image.horizon, np.float32)
        samples, crop = scene.image.supersample, scene.image.crop or (0, 0, *scene.image.size)
        rows = gradient(top, bottom, scene.image.size[1] * samples)[crop[1] * samples :][: self.size[1]]
        self._backdrop = np.ascontiguousarray(np.broadcast_to(rows[:, None], (self.size[1], self.size[0], 3)))
        if scene.image.horizon is not None:
            self._backdrop = dithered(rows, self.size[0], samples, scene.image.tone, scene.image.exposure, crop[:2])
        self._drawing: Drawing

    def draw(
        self, positions: NDArray[np.float32], lengths: NDArray[np.float32], at: float, workers: int,
        before: NDArray[np.float32] | None = None,
    ) -> Drawing:  # fmt: skip
        """Draw strands (blocks, n + 1, 3 W) with segment rest lengths (blocks, W) at a time in seconds.

        ``before``: the strands a frame earlier, for a shutter that is open; None: they have not moved.
        """
        self._drawing = Drawing(self._blank())
        self._clock = time.perf_counter()
        scene, camera = self.scene, self.scene.camera
        if self.children is not None:
            self.tones, self.ids = self.children.select(positions)
        recorder = Recorder(self) if scene.image.aovs else None
        if not lens.is_sampled(camera):
            image, _ = self._expose(positions, lengths, lens.Exposure(at, 1.0), workers, recorder=recorder)
        else:
            image = self._average(positions, before, lengths, at, workers)
        self._develop(image, self._drawing.image)
        if recorder is not None:
            if lens.is_sampled(camera):  # layers are those of a pinhole at the frame's own time
                self._expose(positions, lengths, lens.Exposure(at, 1.0), workers, recorder=recorder, pinhole=True)
            self._drawing.aovs = recorder.layers(image)
        self._lap("film")
        return self._drawing

    def _average(
        self, positions: NDArray[np.float32], before: NDArray[np.float32] | None, lengths: NDArray[np.float32],
        at: float, workers: int,
    ) -> NDArray[np.float32]:  # fmt: skip
        """The mean of a frame's exposures (see `lens`), linear, (height, width, 3)."""
        scene, camera = self.scene, self.scene.camera
        total = self.scratch.take("total", (self.size[1], self.size[0], 3), np.float32)
        total.fill(0)
        carried = any(use.name == "emitter_motion" for use in scene.rules)
        moving = camera.shutter > 0 and before is not None
        where, maps = positions, None
        shots = lens.exposures(camera, scene.seed, at, scene.time.fps)
        for shot in shots:
            if moving:
                assert before is not None
                where = self.scratch.take("between", positions.shape, np.float32)
                start = at - 1 / scene.time.fps
                lens.between(before, positions, scene.emitter, carried, start, at, shot, where)
                self._lap("curves")
            image, made = self._expose(where, lengths, shot, workers, maps)
            maps = made if camera.shutter == 0 else None  # with the shutter closed the light does not change
            np.add(total, image, out=total)
            self._lap("film")
        total *= np.float32(1 / len(shots))
        self._drawing.counts["exposures"] = len(shots)
        return total

    def _expose(
        self, positions: NDArray[np.float32], lengths: NDArray[np.float32], shot: lens.Exposure, workers: int,
        made: ShadowMaps | None = None, recorder: Recorder | None = None, pinhole: bool = False,
    ) -> tuple[NDArray[np.float32], ShadowMaps | None]:  # fmt: skip
        """One exposure, linear, and the shadow maps that it used: those ``made`` before, or its own."""
        scene, scratch, at = self.scene, self.scratch, shot.at
        strands = min(needed(scene, at), len(self.tones))
        if self.children is not None:
            positions, lengths = self.children.grow(positions, lengths, at, strands, scratch, self.ids)
            self._lap("children")
        level = level_of(scene, at, positions, strands, self.ids, self._thins)
        bounds = bounds_of(positions, strands, None if level is None else level.fade)
        view = self._view(shot, bounds, pinhole)
        portions = self._portions(strands, positions.shape[1] - 1)

        spacing = self._spacing if level is None else self._spacing / math.sqrt(level.share)
        thickness = thickness_of(scene.material, view, bounds)
        maps = made or plan_maps(scene.lights, bounds, scratch, thickness, spacing, self._counts)
        fresh = maps is not None and made is None
        if made is None:
            self._occlude(positions, strands, bounds, thickness, level, at)
        self._lap("shadow")
        if maps is not None and fresh and len(portions) > 1:
            # every strand has to be in the maps before the first is shaded
            for draw in (maps.add, maps.weigh) if maps.deep else (maps.add,):
                for begin, end in portions:
                    lines = self._flatten(positions, lengths, begin, end, view, True, level)
                    draw(lines, workers, scratch)
                    self._lap("shadow")
                (maps.divide if draw == maps.add else maps.finish)()

        keys = scratch.take("keys", self.size[0] * self.size[1], np.uint64)
        packed = self._solids(at)
        self._clear(keys, view, packed)
        self._lap("raster")
        image = scratch.take("image", (self.size[1], self.size[0], 3), np.float32)
        np.copyto(image, self._backdrop)
        self._lap("film")

        base = 0
        segments = 0
        front: NDArray[np.uint64] | None = None
        lights = pack_lights(scene.lights, maps, bounds)
        for begin, end in portions:
            casts = maps is not None or bool(self._traced)
            lines = self._flatten(positions, lengths, begin, end, view, casts, level)
            if maps is not None and fresh and len(portions) == 1:
                maps.build(lines, workers, scratch)
            grids = [
                grid_of(light, lines, thickness, scene.material.opacity, bounds, workers, scratch, number)
                for number, light in enumerate(self._traced)
            ]
            self._lap("shadow")
            screen = raster.to_screen(lines, view, scratch)
            least = 1.0 if self.coverage is None else 0.0
            widths = widths_of(lines, screen, view, scene.material, least, self._thins, scratch)
            body = body_of(lines, screen, widths, scene.image.supersample, scratch) if self._rounds else None
            self._lap("curves")
            segments += lines.segments
            if self.coverage is not None:
                if recorder is not None:
                    front = keys.copy()
                self._before("coverage")
                edges = None if packed is None else find_edges(keys, packed, view, self.size, scratch)
                for layer in self.coverage.layers(lines, screen, widths, edges, workers, scratch):
                    self._lap("raster")
                    self._before("light")
                    if edges is not None and packed is not None and layer.top == 0:  # strands are laid over the solids
                        shade = partial(self._surfaces, view, lights, maps, packed, at)
                        shade(keys, *self.size, NO_SPOTS, image)
                        edges.lay(shade, image, self._backdrop)
                    clear = self._trace(grids, lines, layer.marks, screen)
                    colours = self._shade(lines, layer.marks, begin, end, view, lights, clear, maps, packed, body)
                    self._lap("shade")
                    layer.compose(colours, image)
                    if body is not None:
                        layer.round_off(body, image)
                    if recorder is not None and front is not None:
                        recorder.layer(layer, lines, screen, self.size[0], front)
                    self._lap("film")
                if recorder is not None and front is not None:
                    recorder.strands(lines, screen, front, 0, begin, view)
                continue
            raster.draw(lines, screen, widths, base, self.size, workers, scratch, keys)
            if recorder is not None:
                recorder.strands(lines, screen, keys, base, begin, view)
            self._lap("raster")
            self._before("light")
            marks = self._mark(lines, keys, base)
            clear = self._trace(grids, lines, marks, screen)
            colours = self._shade(lines, marks, begin, end, view, lights, clear, maps, packed, body)
            self._lap("shade")
            film.colours(keys, base, screen, lines.per, lines.stride, colours, image)
            if body is not None:
                body.over_seen(keys, base, lines, image)
            self._lap("film")
            base += len(lines.world)
        if packed is not None and self.coverage is None:
            self._surfaces(view, lights, maps, packed, at, keys, *self.size, NO_SPOTS, image)
            self._lap("shade")
        if recorder is not None:
            recorder.rest(keys if front is None else front, view, packed, lights, maps, self._skin())
        drawn = strands if level is None else int(np.count_nonzero(level.fade))
        self._drawing.counts |= {
            "strands": drawn,
            "particles": drawn * (positions.shape[1] - 1),
            "segments": segments,
            "fragments": self._fragments(keys, len(portions)),
        }
        if self.coverage is not None:
            self._drawing.counts["fragment_bytes"] = self.coverage.most
        if self._traced:
            self._drawing.counts["grid_bytes"] = sum(grid.nbytes for grid in grids)
        self._lap("film")
        return image, maps

    def _view(self, shot: lens.Exposure, bounds: NDArray[np.float64], pinhole: bool) -> View:
        """The camera at an exposure's moment: what the crop window shows, through its point of the lens."""
        scene, samples = self.scene, self.scene.image.supersample
        width, height = scene.image.size
        view = camera_view(scene.camera, shot.at, width * samples, height * samples, bounds)
        if scene.image.crop is not None:
            view = view.cropped(*(samples * number for number in scene.image.crop))
        if pinhole:
            return view
        if self.coverage is None:  # sorted strands have what they cover of a pixel, wherever they lie in it
            view = view.shifted(shot.x, shot.y)
        return lens.through_lens(view, scene.camera, shot)

    def rehearse(self, part: str) -> None:
        """Run a part of a frame with nothing to be seen, so that it is compiled: its "light", which is all that comes
        after the z-buffer, or its "coverage"."""
        width, height = self.size
        bounds = np.array([[-1.0] * 3, [1.0] * 3])
        view = camera_view(self.scene.camera, 0.0, width, height, bounds)
        if part == "coverage":
            self._rehearse_coverage(view)
            return
        maps = plan_maps(self.scene.lights, bounds, self.scratch, Thickness(0.01), 0.1)
        self._occlusion = occlusion.nothing() if self.scene.occluded else None
        lights = pack_lights(self.scene.lights, maps, bounds)
        lines = Polylines(np.array([0, 1]), np.zeros((1, 3), np.float32))
        keys = np.full(width * height, raster.kernel.EMPTY)
        image = self._backdrop.copy()
        packed = self._solids(0.0)
        marks = self._mark(lines, keys, 0) if self.coverage is None else np.zeros(1, np.uint8)
        clear = np.ones((len(self._traced), 1), np.float32) if self._traced else None
        colours = self._shade(lines, marks, 0, 1, view, lights, clear, maps, packed)
        if self.coverage is None:
            film.colours(keys, 0, lines.world, lines.per, lines.stride, colours, image)
        else:
            self.coverage.nothing().compose(colours, image)
        if packed is not None:
            self._surfaces(view, lights, maps, packed, 0.0, keys, *self.size, NO_SPOTS, image)
        self._develop(image, self._blank())

    def _rehearse_coverage(self, view: View) -> None:
        if self.coverage is None:
            return
        lines = Polylines(np.array([0, 2]), np.zeros((2, 3), np.float32))
        screen = np.zeros((2, 3), np.float32)  # behind the eye
        keys = np.full(self.size[0] * self.size[1], raster.kernel.EMPTY)
        packed = self._solids(0.0)
        edges = None if packed is None else find_edges(keys, packed, view, self.size, self.scratch)
        if edges is not None:
            edges.lay(lambda *picture: None, self._backdrop.copy(), self._backdrop)
        widths = np.zeros(2, np.float32) if self.scene.material.width > 0 else None
        for _ in self.coverage.layers(lines, screen, widths, edges, 1, self.scratch):
            pass

    def _most(self, groom: Groom) -> int:
        """Strands that are drawn of a groom."""
        return groom.strands if self.children is None else self.children.count

    def _fragments(self, keys: NDArray[np.uint64], portions: int) -> int:
        """Samples in which a strand is seen; with several portions a later one may hide what an earlier one counted.
        Of sorted strands, all that they cover before the solids."""
        if self.coverage is not None:
            return self.coverage.fragments
        if portions == 1:
            return self._seen
        return int(np.count_nonzero((keys & np.uint64(0xFFFFFFFF)) < solids.FIRST))

    def _lap(self, stage: str) -> None:
        now = time.perf_counter()
        self._drawing.seconds[stage] = self._drawing.seconds.get(stage, 0.0) + now - self._clock
        self._clock = now

    def _portions(self, strands: int, n: int) -> list[tuple[int, int]]:
        """Ranges of strands, whole blocks each, that hold at most `PORTION` vertices; all in one to be sorted, and to
        be held against each other."""
        if self.coverage is not None or self._traced:
            return [(0, strands)]
        vertices = (n - 1) * greatest_pieces(self.scene.curves) + 1
        step = max(PORTION // vertices // W, 1) * W
        return [(begin, min(begin + step, strands)) for begin in range(0, strands, step)]

    def _flatten(
        self, positions: NDArray[np.float32], lengths: NDArray[np.float32], begin: int, end: int, view: View,
        keep: bool, level: Level | None,
    ) -> Polylines:  # fmt: skip
        blocks = slice(begin // W, -(-end // W))
        fade = None if level is None else level.fade[begin:end]
        lines = flatten(
            positions[blocks], lengths[blocks], end - begin, self.scene.curves, view, keep, self.scratch, fade
        )
        if level is not None:
            lines = replace(lines, scale=level.scale[begin:end])
            if not self._thins:
                detail.shorten(lines.first, lines.world, fade)
        if self._traced:  # shadows of single strands are finer than half a segment
            lines = replace(lines, stride=1)
        if lines.error is not None:
            self._drawing.curve_px_max = max(lines.error, self._drawing.curve_px_max or 0.0)
        self._lap("curves")
        return lines

    def _solids(self, at: float) -> list[NDArray[np.float32]] | None:
        if not self.visible:
            return None
        return pack_solids(self.visible, self.scene.emitter, at)

    def _clear(self, keys: NDArray[np.uint64], view: View, packed: list[NDArray[np.float32]] | None) -> None:
        if packed is None:
            keys.fill(raster.kernel.EMPTY)
        else:
            solids.draw(*packed, frames_of(packed, view), view.pack(), *self.size, keys)

    def _mark(self, lines: Polylines, keys: NDArray[np.uint64], base: int) -> NDArray[np.uint8]:
        """(V,) not zero at the lit vertices of what is seen in the z-buffer."""
        count = len(lines.world)
        marks = self.scratch.take("marks", count, np.uint8)
        marks.fill(0)
        self._seen = film.mark(keys, base, count, lines.per, lines.stride, marks)
        return marks

    def _trace(
        self, grids: list[Grid], lines: Polylines, marks: NDArray[np.uint8], screen: NDArray[np.float32]
    ) -> NDArray[np.float32] | None:
        """(lights, V) what strands leave of each light with exact shadows at the vertices that are marked; None where
        there is no such light."""
        if not grids:
            return None
        clear = self.scratch.take("clear", (len(grids), len(lines.world)), np.float32)
        for row, grid in zip(clear, grids, strict=True):
            grid.visibility(lines, marks, screen, row)
        self._lap("shadow")
        return clear

    def _shade(
        self, lines: Polylines, marks: NDArray[np.uint8], begin: int, end: int, view: View,
        lights: NDArray[np.float32], clear: NDArray[np.float32] | None, maps: ShadowMaps | None,
        packed: list[NDArray[np.float32]] | None, body: Body | None = None,
    ) -> NDArray[np.float32]:  # fmt: skip
        """(V, 3) radiance at the vertices that are marked; what was there before, or anything, at the others."""
        colours = self.scratch.take("colours", (len(lines.world), 3), np.float32)
        p = self.palette
        shade_strands.strands(
            lines.first, lines.world, marks, self.tones[begin:end], view.pack(), p.colour, p.tint, p.diffuse,
            np.array(self.scene.ambient, np.float32), self.sky, *self._around(), p.lobes, p.fibre, p.nodes, p.paths,
            p.dual, p.dual_scale, lights, clear, *self._maps(maps), *(packed or (None,) * 4), self._skin(),
            *((None,) * 3 if body is None else (body.slots, p.columns, body.profile)), colours,
        )  # fmt: skip
        return colours

    def _surfaces(
        self, view: View, lights: NDArray[np.float32], maps: ShadowMaps | None, packed: list[NDArray[np.float32]],
        at: float, keys: NDArray[np.uint64], width: int, height: int, spots: NDArray[np.float32],
        image: NDArray[np.float32],
    ) -> None:  # fmt: skip
        shade_surfaces.surfaces(
            keys, width, height, view.pack(), np.array(self.scene.ambient, np.float32), self.sky, *self._around(),
            self.palette.colour, lights, self.palette.veil,
            *self._maps(maps), *packed, paint_of(self.visible, self.scene.emitter, at), self._skin(), spots, image,
        )  # fmt: skip

    def _develop(self, image: NDArray[np.float32], out: NDArray[np.uint8]) -> None:
        settings = self.scene.image
        curve, roll = curve_of(settings.tone)
        film.develop(image, settings.supersample, np.float32(2.0**settings.exposure), curve, roll, out)

    def _blank(self) -> NDArray[np.uint8]:
        width, height = self.scene.image.drawn
        return np.empty((height, width, 3), np.uint8)

    def _occlude(
        self, positions: NDArray[np.float32], strands: int, bounds: NDArray[np.float64], thickness: Thickness,
        level: Level | None, at: float,
    ) -> None:  # fmt: skip
        """Occlusion of the light from everywhere, where the scene wants it and there is such light."""
        scene = self.scene
        if scene.occluded:
            self._occlusion = occlusion.build(
                scene.ambient_occlusion, positions, strands, bounds, thickness, level, self._solids(at), self.scratch
            )

    def _around(self) -> tuple[Any, Any]:
        found = self._occlusion
        return (None, None) if found is None else (found.volume, found.box)

    def _maps(self, maps: ShadowMaps | None) -> tuple[Any, ...]:
        return (None,) * 5 if maps is None else (maps.texels, maps.stacks, maps.starts, maps.sizes, maps.packed)

    def _skin(self) -> np.float32:
        """Depth under a solid's surface that still counts as on it: a hundredth of a strand."""
        return np.float32(0.01 * self.scene.emitter.length)
