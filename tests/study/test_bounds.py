"""The loops of bounds do the work that they claim: each against a plain twin in NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from strandcli.study.bounds import loops
from strandcli.study.bounds.kernels import light

COUNTS = {
    "lights": 2, "lights_with_maps": 1, "map_layers": 3, "map_numbers": 8192, "lit_vertices": 3000,
    "solid_samples": 2000, "samples": 4096, "samples_a_side": 2, "fragments_blended": 20_000, "fragments_found": 20_000,
    "particles": 1000, "strands": 100, "vertices": 4000, "splats": 5000, "particles_a_strand": 7, "particle_steps": 900,
    "guides": 20, "children": 80, "child_particles": 800, "map_texels": 5000, "line_samples": 5000,
    "strand_vertices_in_maps": 6000, "strand_samples": 3000, "bytes": 4096,
}  # fmt: skip


def run(name: str) -> tuple[Any, ...]:
    """The arrays of a loop that has run twice, as the second run is one that is timed."""
    loop = loops.BOUNDS[name].make(COUNTS, loops.BOUNDS[name].count(COUNTS))
    loop.run()
    return loop.arrays


def test_every_stage_has_a_bound_and_every_bound_a_stage() -> None:
    assert sorted(name for names in loops.STAGES.values() for name in names) == sorted(loops.BOUNDS)
    for name, bound in loops.BOUNDS.items():
        count = bound.count(COUNTS)
        loop = bound.make(COUNTS, count)
        assert 0.5 * count <= loop.elements <= 2 * count or loop.elements <= 4096, name
        assert bound.memory(COUNTS) > 0
        assert bound.operations(COUNTS) > 0


def test_motion_falls_and_keeps_lengths() -> None:
    now, before, rest, fall, out = run("move")
    wanted = np.empty(now.shape)
    wanted[:, 0] = now[:, 0]
    free = 2 * now.astype(float) - before
    free[:, :, 1] -= fall
    for i in range(1, now.shape[1]):
        way = free[:, i] - wanted[:, i - 1]
        wanted[:, i] = wanted[:, i - 1] + way * rest[:, None] / np.sqrt((way**2).sum(1, keepdims=True))
    assert np.abs(out - wanted).max() < 1e-4
    assert np.abs(out - now).max() > 0.01


def test_children_are_weighted_sums_of_three_guides() -> None:
    guides, parents, weights, out = run("children")
    assert np.abs(out - np.einsum("ck,ckn->cn", weights, guides[parents])).max() < 1e-6
    assert len({tuple(row) for row in parents}) > 10


def test_curves_pass_through_their_controls_and_are_projected() -> None:
    controls, basis, view, world, screen = run("curves")
    assert basis.shape == (4, 4)
    blocks, n, _, lanes = controls.shape
    points = controls.astype(float).transpose(0, 3, 1, 2).reshape(blocks * lanes, n, 3)
    assert np.abs(world[:, ::4] - points[:, 1:-2]).max() < 1e-6
    middle = (9 * (points[:, 1:-2] + points[:, 2:-1]) - points[:, :-3] - points[:, 3:]) / 16
    assert np.abs(world[:, 2::4] - middle).max() < 1e-6
    seen = world @ view[:, :3].T + view[:, 3]
    assert np.abs(screen[..., :2] - seen[..., :2] / seen[..., 2:]).max() < 1e-3
    assert np.abs(screen[..., 2] - 1 / seen[..., 2]).max() < 1e-6


def test_lines_are_projected() -> None:
    world, view, screen = run("lines")
    seen = np.einsum("ij,njl->nil", view[:, :3], world) + view[None, :, 3:]
    assert np.abs(screen[:, :2] - seen[:, :2] / seen[:, 2:]).max() < 1e-3
    assert np.abs(screen[:, 2] - 1 / seen[:, 2]).max() < 1e-6


def test_splats_are_added_to_two_texels_of_their_layer() -> None:
    splats, layer, area, side, maps = run("splats")
    wanted = np.zeros(maps.shape)
    low = np.floor(splats).astype(int)
    share = splats[..., 0] - low[..., 0]
    tile = np.broadcast_to(np.arange(len(maps))[:, None], layer.shape)
    for right in (0, 1):
        part = share if right else 1 - share
        np.add.at(wanted, (tile, layer, low[..., 1] * side + low[..., 0] + right), area * part)
    assert np.abs(maps - wanted).max() < 1e-4 * wanted.max()


def test_texels_keep_their_nearest_and_farthest_depth() -> None:
    place, depth, texels = run("texels")
    wanted = np.full(texels.shape, 0.5, np.float32)
    for tile in range(len(place)):
        np.minimum.at(wanted[tile, :, 0], place[tile], depth[tile])
        np.maximum.at(wanted[tile, :, 1], place[tile], depth[tile])
    assert np.array_equal(texels, wanted)


def test_fragments_are_sorted_by_pixel() -> None:
    pixel, depth, counts, out, order = run("fragments")
    for tile in range(len(pixel)):
        wanted = np.argsort(pixel[tile], kind="stable")
        assert np.array_equal(order[tile], wanted)
        assert np.array_equal(out[tile], depth[tile][wanted])
        assert np.array_equal(counts[tile], np.bincount(pixel[tile], minlength=counts.shape[1]))


def test_samples_keep_their_least_key() -> None:
    place, key, keys = run("keys")
    wanted = np.full(keys.shape, np.iinfo(np.uint64).max)
    for tile in range(len(place)):
        np.minimum.at(wanted[tile], place[tile], key[tile])
    assert np.array_equal(keys, wanted)


def transmittance(maps: Any, number: int, places: Any) -> Any:
    """e^-τ of one map at places from 0 to 1, in double precision."""
    layers, side = maps.shape[1] - 1, maps.shape[2]
    x, y = places[:, 0] * np.float32(side - 2), places[:, 1] * np.float32(side - 2)
    z = places[:, 2] * np.float32(np.float32(layers) * np.float32(1 - 1e-6))
    column, row, k = (np.floor(one).astype(int) for one in (x, y, z))
    total = np.zeros(len(places))
    for right in (0, 1):
        for down in (0, 1):
            part = (x - column if right else 1 - x + column) * (y - row if down else 1 - y + row)
            low, high = (maps[number, k + over, row + down, column + right] for over in (0, 1))
            total += part * (low + (z - k) * (high - low))
    return np.exp(-total)


def entry(table: Any, x: Any, y: Any) -> Any:
    """A table between its entries."""
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    x, y = x - column, y - row
    top = (1 - x) * table[row, column] + x * table[row, column + 1]
    return (1 - y) * top + y * ((1 - x) * table[row + 1, column] + x * table[row + 1, column + 1])


def test_vertices_are_lit_through_maps_and_tables() -> None:
    places, ways, lights, mapped, maps, tables, out = run("vertices")
    assert len(places) % (light.TASKS * light.LANES) == 0
    fine = tables.shape[1] - 2
    wanted = np.zeros(len(places))
    for i, way in enumerate(lights.astype(float)):
        sine = ways @ way
        cosine = np.sqrt(np.maximum(1 - sine**2, 0))
        turn = (ways[:, 0] + 1) / 2 * fine
        lit = cosine * entry(tables[0], (sine + 1) / 2 * fine, turn) * entry(tables[1], cosine * fine, turn)
        wanted += lit * (transmittance(maps, i, places) if i < mapped else 1)
    assert np.abs(out - wanted[:, None] * [1, 2, 3]).max() < 2e-3
    assert np.std(wanted) > 0.1


def test_pixels_are_lit_through_maps() -> None:
    places, lights, mapped, maps, out = run("pixels")
    wanted = sum(
        max(float(way[1]), 0) * (transmittance(maps, i, places) if i < mapped else np.ones(len(places)))
        for i, way in enumerate(lights)
    )
    assert np.abs(out - wanted[:, None] * [1, 2, 3]).max() < 2e-3


def test_fragments_light_is_summed_by_pixel() -> None:
    ends, vertex, weight, along, colours, image = run("blend")
    between = (1 - along)[:, None] * colours[vertex] + along[:, None] * colours[vertex + 1]
    wanted = np.add.reduceat(weight[:, None] * between, ends[:-1])
    assert np.abs(image - wanted).max() < 1e-4
    assert (np.diff(ends) > 1).all()


def test_samples_have_the_light_between_two_vertices() -> None:
    vertex, along, colours, image = run("colour")
    t = along[:, None]
    assert np.abs(image - (1 - t) * colours[vertex] - t * colours[vertex + 1]).max() < 1e-6


@pytest.mark.parametrize("samples", [1, 2])
def test_the_film_is_the_mean_light_of_samples_by_a_curve(samples: int) -> None:
    loop = loops.make_film({"samples_a_side": samples}, 4096)
    loop.run()
    image, _, curve, out = loop.arrays
    height, width, _ = out.shape
    mean = image.reshape(height, samples, width, samples, 3).astype(float).mean((1, 3))
    assert np.abs(out.astype(int) - curve[(mean * 65535).astype(int)]).max() <= 1


def test_a_files_bytes_are_differences_from_the_left() -> None:
    image = np.random.default_rng(0).integers(0, 255, (5, 7, 3), np.uint8)
    (rows,) = loops.make_deflate(COUNTS, 105, image).arrays
    assert np.array_equal(np.cumsum(rows.reshape(5, 7, 3), axis=1, dtype=np.uint8), image)
