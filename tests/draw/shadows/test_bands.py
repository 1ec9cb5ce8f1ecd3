"""Maps are drawn in bands of rows, one owner each: neither the bands nor their owners may show in what is drawn."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from opacity_twin import splatted
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.geometry.extent import Thickness
from strandcli.draw.shadows.kernels import opacity
from strandcli.draw.shadows.shadow import ShadowMaps, plan_maps
from strandcli.draw.zbuffer.raster import ROWS
from strandcli.scene.model import DirectionalLight, Light, PointLight, Shadow

BOX = np.array([[-1.0, -1, -1], [1, 1, 1]])
WIDE = Thickness(0.01, 0.5)
LAYERS = 5


def lights_of(size: int) -> tuple[Light, ...]:
    """One light of each kind under each kind of map, with several bands."""
    deep, flat = Shadow(model="opacity", size=size, layers=LAYERS, texel=1e-9), Shadow(size=size)
    return tuple(
        light
        for shadow in (deep, flat)
        for light in (
            DirectionalLight(direction=(-0.5, -1.0, -0.3), shadow=shadow),
            PointLight(position=(2.0, 4.0, 1.0), shadow=shadow),
            PointLight(position=(0.1, 0.05, -0.1), shadow=shadow),
        )
    )


def walks(count: int, seed: int) -> Polylines:
    """Polylines that stay in the box, of long pieces and short ones."""
    rng = np.random.default_rng(seed)
    step = rng.choice([0.005, 0.03, 0.2], (count, 1, 1))
    world = np.clip(rng.uniform(-1, 1, (count, 1, 3)) + (step * rng.normal(size=(count, 8, 3))).cumsum(1), -1, 1)
    return Polylines(np.arange(count + 1) * 8, world.astype(np.float32).reshape(-1, 3))


def built(lights: tuple[Light, ...], lines: Polylines, workers: int) -> ShadowMaps:
    maps = plan_maps(lights, BOX, Scratch(), WIDE)
    assert maps is not None
    maps.build(lines, workers, Scratch())
    return maps


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), size=st.integers(ROWS + 2, 5 * ROWS))
def test_maps_have_the_same_bits_in_any_number_of_bands(seed: int, size: int) -> None:
    lines, lights = walks(150, seed), lights_of(size)
    alone = built(lights, lines, 1)
    assert alone.stacks is not None
    assert alone.texels is not None
    for workers in (2, 3, 4, 5):
        maps = built(lights, lines, workers)
        np.testing.assert_array_equal(maps.stacks, alone.stacks)
        np.testing.assert_array_equal(maps.texels, alone.texels)


def weights(maps: ShadowMaps) -> np.ndarray:
    """(size, size): τ of all strands in each texel of the first map."""
    assert maps.stacks is not None
    size, half = int(maps.sizes[0]), int(maps.sizes[0]) // 2
    heads = maps.stacks[: opacity.HEAD * half * half].reshape(-1, opacity.HEAD)
    rows = maps.stacks[opacity.HEAD * half * half :].reshape(-1, opacity.stride_for(LAYERS))
    ends = rows[heads[:, opacity.ROW].astype(int), -4:]
    np.testing.assert_array_equal(heads[:, opacity.WHOLE :], ends)
    ends = ends.reshape(half, half, 2, 2)
    return ends.transpose(0, 2, 1, 3).reshape(size, size)


@pytest.mark.parametrize("workers", [1, 3])
def test_no_weight_is_lost_at_the_edge_of_a_band(workers: int) -> None:
    lines, sun = walks(400, 3), lights_of(4 * ROWS)[0]
    maps = built((sun,), lines, workers)
    assert maps.sizes[0] == 4 * ROWS
    expected, found = splatted(maps, lines, WIDE)[..., -1], weights(maps)
    assert expected[ROWS - 1 : ROWS + 1].sum() > 0.005 * expected.sum()
    assert found.sum(dtype=np.float64) == pytest.approx(expected.sum(), rel=1e-4)
    np.testing.assert_allclose(found.sum(1, dtype=np.float64), expected.sum(1), atol=2e-3 * expected.sum(1).max())
