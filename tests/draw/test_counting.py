"""What a counting renderer counts, against counts made otherwise, and its pictures."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from strand_kit import scene_of
from strandcli.draw import canvas, counting
from strandcli.draw.canvas import Canvas
from strandcli.draw.common.drawing import Drawing, ProcessorDrawing
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.renderer import Renderer
from strandcli.draw.shadows.kernels.map_parts import StrandsInMap
from strandcli.draw.shadows.strands_in_map import coarseness, parts_of, view_numbers
from strandcli.draw.view.camera import View
from strandcli.frame_renderer import FrameRenderer
from strandcli.scene import Scene
from strandcli.stages import RunOptions, SimulationStage

HAIRY = """
emitter: {strands: 40, particles: 5, length: 0.5}
image: {size: [64, 48], resolver: %s, supersample: %d, aovs: [solid]}
material: {width: 0.01}
children: {count: 3}
solids:
- {kind: plane, position: [0, -0.5, 0]}
lights:
- {kind: directional, direction: [0, -1, 0.5], shadow: {model: %s, size: 64}}
- {kind: point, position: [1, 2, 1], shadow: {model: off}}
"""


def drawn(scene: Scene, kind: type[Renderer]) -> Any:
    """The first frame."""
    moved = SimulationStage(scene, [1], None, RunOptions())
    return FrameRenderer(moved, kind)(moved.begin(1))


@pytest.mark.long
def test_counts_of_sorted_strands_are_those_of_the_fragments_blended(monkeypatch: pytest.MonkeyPatch) -> None:
    # a map of so many texels that few of the segments in it end near a border between two
    scene = scene_of((HAIRY % ("sorted", 2, "opacity")).replace("size: 64", "size: 256, texel: 0.01"))
    lit, blended, lines = set(), 0, []
    blend, shadows = Canvas._blend, counting.count_in_maps

    def watch(self: Canvas, layer: Any, batch: Any) -> None:
        nonlocal blended
        parts = layer.fragments
        for tile in np.flatnonzero(parts.begin >= 0):
            count = int(parts.counts.reshape(len(parts.begin), -1)[tile].sum())
            vertices = parts.vertex[parts.begin[tile] : parts.begin[tile] + count].astype(int)
            of_strands = vertices[vertices < len(batch.lines.world)]
            lit.update(of_strands, of_strands + parts.stride)
            blended += count
        blend(self, layer, batch)

    def keep(maps: Any, polylines: Any, scratch: Any) -> Any:
        stride = coarseness(polylines, maps.views[0])
        lines.append((maps, polylines.world.copy(), polylines.first.copy(), stride))
        return shadows(maps, polylines, scratch)

    monkeypatch.setattr(canvas.Canvas, "_blend", watch)
    monkeypatch.setattr(counting, "count_in_maps", keep)
    frame, plain = drawn(scene, counting.CountingRenderer), drawn(scene, Renderer)
    counts = frame.report["counts"]
    assert np.array_equal(frame.image, plain.image)
    assert not set(counts) <= set(plain.report["counts"])
    assert counts["fragments_found"] == plain.report["counts"]["fragments"]
    assert counts["fragments_blended"] * 2 == blended  # two frames were watched
    assert counts["lit_vertices"] == len(lit)
    assert counts["child_particles"] == 40 * 3 * counts["particles"] // counts["strands"]
    assert counts["samples"] == 4 * 64 * 48
    assert counts["solid_samples"] == pytest.approx(4 * frame.aovs["solid"].sum(), rel=0.01)
    assert 0 < counts["solid_samples"] < counts["samples"]
    assert (counts["lights"], counts["lights_with_maps"]) == (2, 1)
    maps, world, first, stride = lines[0]
    assert counts["vertices"] == len(world)
    assert counts["map_numbers"] == len(maps.stacks)
    wanted, unsure = splats_by_numpy(maps.views[0], world, first, stride)
    assert abs(counts["splats"] - wanted) <= unsure < wanted // 50


def splats_by_numpy(view: Any, world: Any, first: Any, stride: int) -> tuple[int, int]:
    """One a row or column of texels that a segment's longer side in the light's view comes to; and how many segments
    are too near a border between texels, or to being left out, for single precision to tell."""
    turned = (world.astype(float) - view.eye) @ np.stack([view.right, view.up, view.forward]).T * view.focal
    count = unsure = 0
    for begin, end in pairwise(first):
        last = None
        for number in range(begin, end, stride):
            place = turned[number] + [view.width / 2, view.height / 2, 0]
            if last is not None:
                side = np.abs(place - last)
                unsure += abs(side.max() - 1) < 1e-3
                if side.max() < 1 and number + stride < end:
                    continue
                long = int(side[1] >= side[0])
                parts = int(side[2] / side[long]) + 1 if side[2] > side[long] else 1
                low, high = sorted((parts * last[long], parts * place[long]))
                count += int(high) + 1 - int(low)
                near = [abs(x - round(x)) for x in (low, high, side[2] / side[long])]
                unsure += min(near) < 1e-3 * max(parts, 1)
            last = place
    return count, int(unsure) * 2


def test_counts_of_a_z_buffer_are_those_of_its_lines_and_keys() -> None:
    scene = scene_of(HAIRY % ("zbuffer", 1, "minmax"))
    frame, plain = drawn(scene, counting.CountingRenderer), drawn(scene, Renderer)
    counts = frame.report["counts"]
    assert np.array_equal(frame.image, plain.image)
    assert counts["strand_samples"] == plain.report["counts"]["fragments"]
    assert counts["line_samples"] >= counts["strand_samples"] > 0
    assert counts["map_texels"] > 0
    assert counts["splats"] == 0


def test_samples_of_lines_are_columns_or_rows_whose_centres_they_pass() -> None:
    rng = np.random.default_rng(3)
    screen = rng.uniform(-5, 25, (60, 3)).astype(np.float32)
    screen[:, 2] = 1
    screen[7, 2] = -1  # behind the eye
    first = np.array([0, 2, 10, 10, 60])
    wanted = 0
    for s in range(4):
        for v in range(first[s] + 1, first[s + 1]):
            a, b = screen[v - 1].astype(float), screen[v].astype(float)
            if min(a[2], b[2]) <= 0:
                continue
            long = 0 if abs(b[0] - a[0]) >= abs(b[1] - a[1]) else 1
            for place in range((20, 16)[long]):
                t = (place + 0.5 - a[long]) / (b[long] - a[long])
                across = a[1 - long] + t * (b[1 - long] - a[1 - long])
                wanted += 0 <= t <= 1 and 0 <= across < (16, 20)[long]
    assert counting.samples_of(first, screen, (20, 16)) == wanted > 50


@pytest.mark.parametrize("kind", [Drawing, ProcessorDrawing])
def test_counting_is_charged_to_no_stage(kind: type[Drawing]) -> None:
    drawing = kind(np.zeros((1, 1, 3), np.uint8))
    assert 0 <= drawing.now() - drawing.clock < 60
    with counting.unclocked(drawing):
        while_inside = drawing.clock
    assert drawing.clock > while_inside
    drawing.lap("shade")
    assert 0 <= drawing.seconds["shade"] < 60


@pytest.mark.parametrize(
    ("long", "rise", "splats"),
    [(0.5, 0, 1), (1.2, 0, 2), (2.6, 0, 3), (3.3, 0, 4), (0.5, 2.4, 2), (200, 0, 0)],
    ids=["in a texel", "in two", "in three", "in four", "along the light", "longer than four maps"],
)
def test_a_segment_has_a_splat_in_each_texel_of_its_longest_side(long: float, rise: float, splats: int) -> None:
    """In a light's view of 2 texels a metre and 20 metres of depth; rise: in texels."""
    axes = np.eye(3)
    view = View(np.zeros(3), axes[0], axes[1], axes[2], False, 2.0, 0.0, 20.0, 32, 32)
    screen = np.array([[3, 9, 0.5], [3 + long, 9, 0.5 + rise / 2 / 20]], np.float32)

    def found() -> int:
        strands = StrandsInMap(np.array([0, 2]), screen, np.float32(0.1), np.float32(0), None)
        return counting.splats_of(parts_of(strands, view_numbers(view), 32, 1, Scratch()), 32, view)

    assert found() == splats
    screen[:, 1] = 35  # beside the map
    assert found() == 0
