"""Drawing of a frame: its exposures, each stage by stage (curves, shadow maps, visibility, light), and the film."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..constants import FILE_POINTS, SORTED_POINTS
from ..groom.children import Children
from ..groom.combed import Combed
from ..groom.followers import Followers
from ..groom.record import Groom
from ..scene.model import Scene
from ..solids import Solids, pack_all
from .bands import bands
from .canvas import Canvas, Exposed
from .common.drawing import Drawing, ProcessorDrawing
from .common.scratch import IN_LIGHT, POSITIONS, Scratch
from .coverage.coverage import Coverage
from .drawn_strands import DrawnStrands
from .film.aovs import Recorder
from .film.film import backdrop_of, develop, grain_of
from .geometry.curves import Polylines
from .geometry.extent import Extents, Thickness, bounds_of, extents_of, thickness_of
from .geometry.spacing import first_emitted, spacing_of
from .lighting import occlusion
from .lighting.environment import sky_of
from .lighting.lighting import Lighting, pack_lights
from .lighting.occlusion import Occlusion
from .lighting.palette import Palette
from .shadows.shadow import ShadowMaps, map_arrays, plan_maps
from .shadows.shadow_model import casts_map, counts_strands, model_of, needs_counts, shades_vertices
from .shadows.strands_in_map import chances_of
from .shadows.vertex_shadows import StrandsInLight
from .strand_batches import StrandBatch, StrandBatches, Strands, divide
from .view import lens
from .view.camera import View, camera_view


class Renderer:
    """Draws frames of one scene; holds everything that does not change from frame to frame."""

    keeps_light = False
    """Whether shadow maps and occlusion of the last picture are reused: strands, solids and lights are the same, and
    shadows do not depend on the view (see `shadows_of_any_view`)."""
    clocked: type[Drawing] = Drawing
    """What keeps a frame's picture and times."""

    def __init__(
        self, scene: Scene, groom: Groom, children: Children | Followers | None = None, combed: Combed | None = None
    ) -> None:  # fmt: skip
        """``children``, ``combed``: of this scene and groom, if they exist already."""
        self.scene = scene
        groom = children.groom if isinstance(children, Followers) else groom
        self.tones, self.scratch = groom.tones, Scratch()
        deep = any(counts_strands(light) for light in scene.lights)
        if children is None and scene.children is not None:
            children = Children(scene, groom)
        self.children = children
        if combed is None and scene.emitter.tie is not None:
            combed = Combed(scene, children.every if isinstance(children, Children) else groom)
        self._of_file = isinstance(children, Followers) or groom.points is not None
        self._deep, self._most = deep, scene.drawn_strands if children is None else children.count
        self.sky = sky_of(scene)
        self.palette = Palette(scene.material, deep, groom.colours, groom.shades)
        self.ids = groom.places
        """(strands,) rank of each strand in the order of emission; None: 0, 1, …"""
        self.size = (scene.image.drawn[0] * scene.image.supersample, scene.image.drawn[1] * scene.image.supersample)
        self.shadowed = [light for light in scene.lights if shades_vertices(light)]
        self.counts_strands = needs_counts(scene)
        self.coverage = None if scene.image.resolver == "zbuffer" else Coverage(self.size, scene.material.opacity)
        # lines one pixel wide, on the screen or in a min/max map, cannot become thinner, so they fade by length
        self.thins = self.coverage is not None and all(
            model_of(light).thins for light in scene.lights if casts_map(light)
        )
        self.drawn = DrawnStrands(groom, children, combed, self.thins, self.scratch)
        self.backdrop, self.grain = backdrop_of(scene.image), grain_of(scene.image)
        self._drawing: Drawing
        self._made: Lighting | None = None

    def draw(
        self, positions: NDArray[np.float32], lengths: NDArray[np.float32], at: float, workers: int,
        before: NDArray[np.float32] | None = None,
    ) -> Drawing:  # fmt: skip
        """Return the picture of strands (blocks, n + 1, 3 W), metres, with segment rest lengths (blocks, W), at a time,
        seconds.

        ``before``: positions one frame earlier, for motion blur; None: the strands have not moved.
        """
        self._drawing = self.clocked(self.blank())
        scene, camera = self.scene, self.scene.camera
        if self.children is not None:
            self.tones, self.ids = self.children.select(positions)
        recorder = Recorder(scene.image) if scene.image.aovs else None
        if not lens.is_sampled(camera):
            made = self._expose(positions, lengths, lens.Exposure(at, 1.0), workers, self._made, recorder)
            self._made = made.light if self.keeps_light else None
        else:
            made = self._average(positions, before, lengths, at, workers)
        self.develop(made.parts[0], self._drawing.image, *made.parts[1:])
        if recorder is not None:
            if lens.is_sampled(camera):  # AOVs are drawn through a pinhole at the frame's own time
                self._expose(positions, lengths, lens.Exposure(at, 1.0), workers, recorder=recorder, pinhole=True)
            self._drawing.aovs = recorder.layers(*made.parts)
        self._drawing.lap("film")
        return self._drawing

    def _average(
        self, positions: NDArray[np.float32], before: NDArray[np.float32] | None, lengths: NDArray[np.float32],
        at: float, workers: int,
    ) -> Exposed:  # fmt: skip
        """Return the mean of a frame's exposures (see `lens`)."""
        scene, camera = self.scene, self.scene.camera
        total = self.scratch.borrow("total", (2 if scene.image.has_alpha else 1, *self.size[::-1], 3), np.float32)
        total.fill(0)
        carried = any(use.name == "emitter_motion" for use in scene.rules)
        moving = camera.shutter > 0 and before is not None
        where, light = positions, None
        shots = lens.exposures(camera, scene.seed, at, scene.time.fps)
        for shot in shots:
            if moving:
                assert before is not None
                where = self.scratch.borrow("between", positions.shape, np.float32)
                lens.interpolate(before, positions, scene.emitter, carried, at - 1 / scene.time.fps, at, shot, where)
                self._drawing.lap("curves")
            made = self._expose(where, lengths, shot, workers, light)
            light = made.light if camera.shutter == 0 else None  # with the shutter closed the light does not change
            for part, added in zip(total, made.parts, strict=True):
                np.add(part, added, out=part)
            self._drawing.lap("film")
        total *= np.float32(1 / len(shots))
        self._drawing.counts["exposures"] = len(shots)
        return Exposed(tuple(total), light)

    def _expose(
        self, positions: NDArray[np.float32], lengths: NDArray[np.float32], shot: lens.Exposure, workers: int,
        made: Lighting | None = None, recorder: Recorder | None = None, pinhole: bool = False,
    ) -> Exposed:  # fmt: skip
        """Return one exposure; made: lighting of an earlier one, of which shadows and occlusion are reused; pinhole:
        whether to ignore lens and jitter."""
        scene, drawing, at = self.scene, self._drawing, shot.at
        strands = self.drawn.at(scene, at, positions, lengths, self.tones, self.ids, drawing)
        if recorder is not None:
            recorder.ids = strands.ids
        extents = extents_of(strands.positions)
        bounds = bounds_of(extents, strands.count, strands.fade)
        view = self._view(shot, bounds, pinhole)
        solids, thickness = self.solids(at), thickness_of(scene.material, view, bounds, strands.shares)
        if made is None:
            maps, hidden = self._plan_shadows(strands, bounds, thickness, solids, self._spacing(strands, extents))
        else:
            maps, hidden = made.maps, made.occlusion
        drawing.lap("shadow")
        batches = self._batches(strands, view, maps is not None)
        lines = next(batches.lines()) if len(batches.ranges) == 1 else None
        if maps is not None and made is None:
            self._fill_maps(maps, batches, lines, workers)
            self.scratch.release(*IN_LIGHT)
        lights = pack_lights(scene.lights, maps, bounds)
        shadows = []
        if self.shadowed and lines is not None:
            strands_in_light = StrandsInLight(
                lines, thickness, scene.material.opacity, bounds, workers, self.scratch, 0, lights, map_arrays(maps)
            )
            shadows = [
                model_of(light).vertex_shadows(light, strands_in_light._replace(number=number))
                for number, light in enumerate(self.shadowed)
            ]
        drawing.lap("shadow")
        lighting = Lighting(scene, self.palette, self.sky, view, at, lights, maps, hidden, solids, self.grain)
        canvas = Canvas(
            self.size, self.backdrop, lighting, shadows, self.shade, recorder, workers, drawing,
            self.scratch,
        )  # fmt: skip
        self._draw_batches(canvas, batches, lines)
        self._note_counts(strands, canvas)
        drawing.lap("film")
        return Exposed(canvas.parts, lighting)

    def _plan_shadows(
        self, strands: Strands, bounds: NDArray[np.float64], thickness: Thickness, solids: Solids | None, spacing: float
    ) -> tuple[ShadowMaps | None, Occlusion | None]:
        """Return empty shadow maps, and the ambient occlusion; None for what the scene does not have."""
        scene = self.scene
        maps = plan_maps(scene.lights, bounds, self.scratch, thickness, spacing, self.counts_strands)
        if not scene.occluded or scene.ambient_occlusion is None:
            return maps, None
        return maps, occlusion.build(
            scene.ambient_occlusion, strands.positions, strands.total, bounds, thickness, strands.level, solids,
            self.scratch, strands.numbers, strands.shares,
        )  # fmt: skip

    def _batches(self, strands: Strands, view: View, mapped: bool) -> StrandBatches:
        """Return the batches in which strands are drawn; ``mapped``: whether they are drawn into shadow maps too."""
        ranges = [(0, strands.count)]  # shadows at vertices need all strands at once
        if not self.shadowed:
            points = strands.positions.shape[1] - 1
            most = None if self.coverage is None else FILE_POINTS if self._of_file else SORTED_POINTS
            ranges = divide(strands.count, points, self.scene.curves, most)
        return StrandBatches(
            self.scene, strands, view, self.thins, ranges, mapped or bool(self.shadowed), self._drawing, self.scratch,
        )  # fmt: skip

    def _fill_maps(self, maps: ShadowMaps, batches: StrandBatches, lines: Polylines | None, workers: int) -> None:
        """Draw all strands into the shadow maps before any is shaded; ``lines``: of the only batch, if they exist."""
        if lines is not None:
            if self.coverage is not None:
                maps.chances = chances_of(batches.strands.ids, batches.strands.count)
            self.scratch.release(*POSITIONS)
            return maps.build(lines, workers, self.scratch)
        for again in (False, True) if maps.deep else (False,):
            for polylines in batches.lines():
                maps.add(polylines, workers, self.scratch, again)
                self._drawing.lap("shadow")
            maps.finish() if again else maps.divide(self.scratch)

    def _draw_batches(self, canvas: Canvas, batches: StrandBatches, lines: Polylines | None) -> None:
        """Draw all strands; ``lines``: polylines of the only batch, if they exist already."""
        if self.coverage is None:
            for batch in batches.seen(1.0, lines):
                canvas.rasterise(batch)
            canvas.finish()
        else:
            canvas.composite_sorted(bands(batches, self.coverage, lines), self.coverage)

    def _note_counts(self, strands: Strands, canvas: Canvas) -> None:
        """Store the numbers of strands, segments and fragments drawn, for the report."""
        level, counts = strands.level, self._drawing.counts
        drawn = strands.count if level is None else int(np.count_nonzero(level.fade))
        counts |= {"strands": drawn, "particles": drawn * (strands.positions.shape[1] - 1)}
        counts |= {"segments": canvas.segments, "fragments": canvas.fragments}
        if self.coverage is not None:
            counts["fragment_bytes"] = self.coverage.peak_bytes

    def shade(
        self, lighting: Lighting, batch: StrandBatch, marks: NDArray[np.uint8], visibility: NDArray[np.float32] | None
    ) -> NDArray[np.float32]:
        """Return the radiance (V, 3) at the marked vertices; at the rest it keeps its last value or is undefined.

        visibility (lights, V): of each light whose model shades vertices, None if there are none.
        """
        colours = self.scratch.borrow("colours", (len(batch.lines.world), 3), np.float32)
        lighting.shade_strands(batch.lines, marks, batch.tones, visibility, batch.profiles, colours)
        return colours

    def solids(self, at: float) -> Solids | None:
        """Return the visible solids at a time, seconds, packed; None if there are none."""
        seen = [solid for solid in self.scene.solids if solid.visible]
        return pack_all(seen, self.scene.emitter, at) if seen else None

    def _view(self, shot: lens.Exposure, bounds: NDArray[np.float64], pinhole: bool) -> View:
        """Return the camera's view at an exposure's time, through its point of the lens, within the crop window."""
        scene, samples = self.scene, self.scene.image.supersample
        width, height = scene.image.size
        view = camera_view(scene.camera, shot.at, width * samples, height * samples, bounds)
        if scene.image.crop is not None:
            view = view.cropped(*(samples * number for number in scene.image.crop))
        if pinhole:
            return view
        if self.coverage is None:  # sorted strands have exact coverage and need no jitter
            view = view.shifted(shot.x, shot.y)
        return lens.through_lens(view, scene.camera, shot)

    def develop(
        self, image: NDArray[np.float32], out: NDArray[np.uint8], through: NDArray[np.float32] | None = None
    ) -> None:
        """Write a linear picture, in samples, to ``out`` as pixels of 8 bits; see `film.develop`."""
        develop(self.scene.image, image, out, through)

    def blank(self) -> NDArray[np.uint8]:
        """Return a picture (height, width, channels) with undefined contents."""
        return np.empty((*self.scene.image.drawn[::-1], self.scene.image.channels), np.uint8)

    def _spacing(self, strands: Strands, extents: Extents) -> float:
        """Return the distance between neighbouring drawn strands, metres, for opacity maps; 0 if there are none. It is
        measured between all of these strands, and converted to the density that level of detail leaves."""
        if not self._deep:
            return 0.0
        count, level, whole, ids = strands.total, strands.level, strands.whole, strands.ids
        even = whole is None and (ids is None or isinstance(self.children, Children))
        among = first_emitted(count, ids) if even else None
        spacing = spacing_of(*((strands.positions, count, among, extents) if whole is None else whole.around()))
        return spacing if level is None else spacing * math.sqrt(count / self._most / level.share)


class ProcessorRenderer(Renderer):
    """A `Renderer` whose times are those of the processor."""

    clocked = ProcessorDrawing


def shadows_of_any_view(scene: Scene) -> bool:
    """Return whether strands are the same lines, of the same width, in the shadow maps of every view."""
    return scene.curves.mode not in ("adaptive", "thinned") and scene.material.width > 0 and scene.detail is None
