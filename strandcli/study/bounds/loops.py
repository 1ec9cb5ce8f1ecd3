"""The bounds: for each the element that a stage works on, what it costs at the least, and the loop that does just that.

A loop works on arrays made up for it, of as many elements as the frame has, but at most `MOST`: more do not fit into
any cache either. What comes where in them is as coherent as in a picture: splats and fragments come tile by tile, and
neighbours among vertices stand near each other.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...constants import W
from ...output import png
from .arrays import COHERENT, Floats, coherent, indices, uniform, whole
from .kernels import buffers, light, pictures, strands

Counts = Mapping[str, int]

LEAST = 2**14
"""Elements of a loop: fewer are over before a clock tells."""
TILE = 32
"""Pixels or texels along a side of a tile."""
TABLE = 64
"""Entries along a side of a fibre's tables."""
REACH = 8
"""A tile's fragments lie on the vertices of so many tiles' share of all."""
TEXELS_AT_MOST = 2048
VIEW = np.array([[500, 0, 9, 1], [0, 500, 9, 1], [0, 0, 1, 4]], np.float32)
"""A view as `kernels.strands.tessellate` takes it."""
CATMULL_ROM = np.array([[0, 2, 0, 0], [-1, 0, 1, 0], [2, -5, 4, -1], [-1, 3, -3, 1]]) / 2


@dataclass(frozen=True)
class Loop:
    """A loop with its arrays."""

    run: Callable[[], object]
    elements: int
    """Elements that it works on."""
    arrays: tuple[Any, ...]
    """What its kernel is called with, read and written."""


@dataclass(frozen=True)
class Bound:
    """What an element costs at the least."""

    element: str
    count: Callable[[Counts], int]
    """The number of elements in a frame, from its counts."""
    memory: Callable[[Counts], float]
    """Bytes that are read and written for an element."""
    operations: Callable[[Counts], float]
    """Additions, multiplications, divisions, comparisons and roots for an element."""
    make: Callable[[Counts, int], Loop]
    """The loop, for a frame's counts and about so many elements."""


def make_move(counts: Counts, elements: int) -> Loop:
    """Strands of as many particles, in blocks of `W`."""
    n = max(counts["particles_a_strand"], 2)
    blocks = whole(elements / (n * W))
    now = uniform(blocks, n, 3, W)
    before, rest = now - np.float32(1e-3), np.full((blocks, W), 0.1, np.float32)
    out = np.empty_like(now)
    arrays = (now, before, rest, np.float32(1e-3), out)
    return Loop(lambda: strands.move(*arrays), blocks * n * W, arrays)


def make_children(counts: Counts, elements: int) -> Loop:
    """Children and guides in the frame's proportion."""
    n = max(counts["child_particles"] // max(counts["children"], 1), 2)
    children = whole(elements / n)
    guides = whole(children * counts["guides"] / max(counts["children"], 1), 3)
    # the guides of neighbouring children are near each other, too
    near = np.arange(children)[:, None] * guides // children + indices(8, children, 3)
    parents = np.minimum(near, guides - 1).astype(np.int32)
    out = np.empty((children, 3 * n), np.float32)
    arrays = (uniform(guides, 3 * n), parents, uniform(children, 3), out)
    return Loop(lambda: strands.interpolate(*arrays), children * n, arrays)


def pieces_of(counts: Counts) -> int:
    """Return the vertices of a polyline for each particle."""
    return whole(counts["vertices"] / max(counts["particles"], 1), 1, 64)


def make_curves(counts: Counts, elements: int) -> Loop:
    """Strands of as many segments, each cut into as many pieces as the frame's are in the mean."""
    pieces = pieces_of(counts)
    n = max(counts["particles"] // max(counts["strands"], 1), 1)
    blocks = whole(elements / (n * pieces * strands.LANES))
    t = np.arange(pieces) / pieces
    basis = (np.stack([t**0, t, t**2, t**3], 1) @ CATMULL_ROM).astype(np.float32)
    world = np.empty((blocks * strands.LANES, n * pieces, 3), np.float32)
    arrays = (uniform(blocks, n + 3, 3, strands.LANES), basis, VIEW, world, np.empty_like(world))
    return Loop(lambda: strands.tessellate(*arrays), world.size // 3, arrays)


def make_lines(counts: Counts, elements: int) -> Loop:
    """Vertices of polylines."""
    world = uniform(whole(elements / strands.LANES), 3, strands.LANES)
    arrays = (world, VIEW, np.empty_like(world))
    return Loop(lambda: strands.project(*arrays), world.size // 3, arrays)


def make_splats(counts: Counts, elements: int) -> Loop:
    """Tiles that together are as large as the maps."""
    layers = counts["map_layers"] + 1
    tiles = whole(counts["map_numbers"] / (TILE * TILE * layers), 1, 4096)
    n = whole(elements / tiles)
    maps = np.zeros((tiles, layers, TILE * TILE), np.float32)
    splats = uniform(tiles, n, 2, high=TILE - 1.01)
    arrays = (splats, indices(layers, tiles, n), uniform(tiles, n), TILE, maps)
    return Loop(lambda: buffers.add_splats(*arrays), tiles * n, arrays)


def tiles_of(counts: Counts, elements: int) -> tuple[int, int]:
    """Return tiles of a picture, and the elements that each has."""
    tiles = max(counts["samples"] // (TILE * TILE), 1)
    return tiles, whole(elements / tiles)


def make_texels(counts: Counts, elements: int) -> Loop:
    """Min/max maps of as many tiles as the picture has."""
    tiles, n = tiles_of(counts, elements)
    texels = np.full((tiles, TILE * TILE, 2), 0.5, np.float32)
    arrays = (indices(TILE * TILE, tiles, n), uniform(tiles, n), texels)
    return Loop(lambda: buffers.widen(*arrays), tiles * n, arrays)


def make_fragments(counts: Counts, elements: int) -> Loop:
    """As many tiles as the picture has, with evenly as many fragments each."""
    tiles, n = tiles_of(counts, elements)
    counted, order = np.empty((tiles, TILE * TILE), np.int32), np.empty((tiles, n), np.int32)
    arrays = (indices(TILE * TILE, tiles, n), uniform(tiles, n), counted, np.empty((tiles, n), np.float32), order)
    return Loop(lambda: buffers.sort_fragments(*arrays), tiles * n, arrays)


def make_keys(counts: Counts, elements: int) -> Loop:
    """As many tiles as the picture has."""
    tiles, n = tiles_of(counts, elements)
    keys = np.full((tiles, TILE * TILE), np.iinfo(np.uint64).max, np.uint64)
    key = np.random.default_rng(0).integers(0, 2**63, (tiles, n), np.uint64)
    arrays = (indices(TILE * TILE, tiles, n), key, keys)
    return Loop(lambda: buffers.keep_nearest(*arrays), tiles * n, arrays)


def maps_of(counts: Counts) -> Floats:
    """Return maps of τ for all lights, of which those with opacity maps are as large as in the frame."""
    lights, mapped, layers = counts["lights"], counts["lights_with_maps"], max(counts.get("map_layers", 0), 1)
    numbers = counts.get("map_numbers", 0) / max(mapped, 1) / (layers + 1)
    side = whole(numbers**0.5, 4, TEXELS_AT_MOST)
    return uniform(max(lights, 1), layers + 1, side, side)


def make_vertices(counts: Counts, elements: int) -> Loop:
    """Vertices of strands whose neighbours are near each other."""
    lights = max(counts["lights"], 1)
    share = light.TASKS * light.LANES
    vertices = whole(elements / (lights * share)) * share
    ways = uniform(vertices, 3, low=-1)
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    directions = uniform(lights, 3, low=-1)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    arrays = (
        coherent(vertices), ways, directions, counts["lights_with_maps"], maps_of(counts), uniform(2, TABLE, TABLE),
        np.empty((vertices, 3), np.float32),
    )  # fmt: skip
    return Loop(lambda: light.light_vertices(*arrays), vertices * lights, arrays)


def make_pixels(counts: Counts, elements: int) -> Loop:
    """Pixels of solids whose neighbours are near each other."""
    lights = max(counts["lights"], 1)
    share = light.TASKS * light.LANES
    pixels = whole(elements / (lights * share)) * share
    directions = uniform(lights, 3, low=-1)
    out = np.empty((pixels, 3), np.float32)
    arrays = (coherent(pixels), directions, counts["lights_with_maps"], maps_of(counts), out)
    return Loop(lambda: light.light_pixels(*arrays), pixels * lights, arrays)


def make_blend(counts: Counts, elements: int) -> Loop:
    """As many pixels as fragments of a mean pixel ask for, whose fragments are of the vertices of some tiles."""
    a_pixel = whole(counts["fragments_blended"] / max(counts["samples"], 1))
    pixels = whole(elements / a_pixel)
    vertices = max(whole(counts["lit_vertices"] * min(elements / max(counts["fragments_blended"], 1), 1)), 1)
    ends = np.arange(pixels + 1, dtype=np.int64) * a_pixel
    tiles = max(pixels // (TILE * TILE), 1)
    begin = np.repeat(np.arange(tiles + 1) * vertices // tiles, TILE * TILE * a_pixel)[: pixels * a_pixel]
    vertex = (begin + indices(max(REACH * vertices // tiles, 1), pixels * a_pixel)) % vertices
    arrays = (
        ends, vertex.astype(np.uint32), uniform(len(vertex)), uniform(len(vertex)), uniform(vertices + 1, 3),
        np.empty((pixels, 3), np.float32),
    )  # fmt: skip
    return Loop(lambda: pictures.blend(*arrays), pixels * a_pixel, arrays)


def make_colour(counts: Counts, elements: int) -> Loop:
    """Samples of strands' vertices, near ones of near vertices."""
    vertices = max(whole(counts["lit_vertices"]), 1)
    vertex = (np.arange(elements) * vertices // elements + indices(COHERENT, elements)) % vertices
    image = np.empty((elements, 3), np.float32)
    arrays = (vertex.astype(np.uint32), uniform(elements), uniform(vertices + 1, 3), image)
    return Loop(lambda: pictures.colour(*arrays), elements, arrays)


def make_film(counts: Counts, elements: int) -> Loop:
    """A picture."""
    samples = max(counts["samples_a_side"], 1)
    side = whole((elements / samples**2) ** 0.5)
    curve = np.linspace(0, 255, 65536).astype(np.uint8)
    out = np.empty((side, side, 3), np.uint8)
    arrays = (uniform(samples * side, samples * side, 3), samples, curve, out)
    return Loop(lambda: pictures.develop(*arrays), (samples * side) ** 2, arrays)


def make_deflate(counts: Counts, elements: int, image: NDArray[np.uint8] | None = None) -> Loop:
    """Bytes of a picture, or made up, as differences from the pixel on the left."""
    if image is None:
        image = np.arange(3 * -(-elements // 3), dtype=np.uint8).reshape(1, -1, 3)
    rows = np.diff(image, axis=1, prepend=np.zeros_like(image[:, :1])).reshape(image.shape[0], -1)
    return Loop(lambda: png.deflate(rows), rows.size, (rows,))


def vertex_lights(counts: Counts) -> int:
    """Return the lights of all lit vertices."""
    return counts["lit_vertices"] * counts["lights"]


def _of(name: str) -> Callable[[Counts], int]:
    return lambda counts: counts.get(name, 0)


def _is(number: float) -> Callable[[Counts], float]:
    return lambda counts: number


BOUNDS: dict[str, Bound] = {
    "move": Bound("particle and step", _of("particle_steps"), _is(36), _is(24), make_move),
    "children": Bound(
        "child's particle", _of("child_particles"),
        lambda c: 12 + 24 * c["children"] / max(c["child_particles"], 1), _is(15), make_children,
    ),
    "curves": Bound("vertex", _of("vertices"), lambda c: 24 + 12 / pieces_of(c), _is(43), make_curves),
    "splats": Bound("splat", _of("splats"), _is(32), _is(5), make_splats),
    "lines": Bound("vertex in a map", _of("strand_vertices_in_maps"), _is(24), _is(21), make_lines),
    "texels": Bound("texel on a line", _of("map_texels"), _is(24), _is(2), make_texels),
    "fragments": Bound("fragment", _of("fragments_found"), _is(24), _is(2), make_fragments),
    "keys": Bound("sample on a line", _of("line_samples"), _is(28), _is(1), make_keys),
    "vertices": Bound(
        "vertex and light", vertex_lights, lambda c: 32 + (32 if c["lights_with_maps"] else 0) + 36 / c["lights"],
        lambda c: 30 + (60 if c["lights_with_maps"] else 0), make_vertices,
    ),
    "pixels": Bound(
        "solid's sample and light", lambda c: c["solid_samples"] * c["lights"],
        lambda c: (32 if c["lights_with_maps"] else 0) + 24 / c["lights"],
        lambda c: 2 + (60 if c["lights_with_maps"] else 0), make_pixels,
    ),
    "blend": Bound("fragment seen", _of("fragments_blended"), _is(36), _is(14), make_blend),
    "colour": Bound("strand's sample", _of("strand_samples"), _is(44), _is(9), make_colour),
    "film": Bound("sample", _of("samples"), lambda c: 12 + 6 / c["samples_a_side"] ** 2, _is(6), make_film),
    "deflate": Bound("byte", _of("bytes"), _is(1), _is(1), make_deflate),
}  # fmt: skip

STAGES: dict[str, tuple[str, ...]] = {
    "simulate": ("move",), "children": ("children",), "curves": ("curves",), "shadow": ("splats", "texels", "lines"),
    "raster": ("fragments", "keys"), "shade": ("vertices", "pixels"), "film": ("film", "blend", "colour"),
    "write": ("deflate",),
}  # fmt: skip
"""The bounds of each stage, whose times add up; the first that the frame has tells what the stage's element is."""
