"""Shadows of strands on solids: filtered, against rays that meet cylinders from all over a light's disc."""

from __future__ import annotations

from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest
from numpy.typing import NDArray

from shadow_kit import optical_depth
from strandcli.constants import W
from strandcli.draw.common.kernels import batch, surface_batch
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.fibre import dual
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.geometry.extent import Thickness
from strandcli.draw.lighting.lighting import given, pack_lights
from strandcli.draw.shadows.kernels import opacity, percentage_closer
from strandcli.draw.shadows.kernels.strand_shadows import ShadowArrays
from strandcli.draw.shadows.shadow import map_arrays, plan_maps
from strandcli.draw.view.camera import axes
from strandcli.scene.model import DirectionalLight, Light, Material, PointLight, Shadow
from strandcli.study.kernels import cylinders
from strandcli.study.pictures.shadow import bundle, frames_along, pieces_of
from tests.draw.shadows.test_opacity import straight

DEEP = Shadow(model="opacity")
SUN = DirectionalLight(direction=(-0.5, -1.0, -0.3), size=6.0, shadow=DEEP)
LAMP = PointLight(position=(2.0, 4.0, 1.0), size=0.5, shadow=DEEP)
WIDE, SPACING = Thickness(0.014, 0.3), 0.06
LINES = straight(1000, 7)


def left(
    by: ModuleType,
    light: Light,
    points: NDArray[np.float64],
    loss: NDArray[np.float32] | None = None,
    lines: Polylines = LINES,
    spacing: float = SPACING,
) -> NDArray[np.float64]:
    """What a light's map leaves of it; in colour with a ``loss``."""
    bounds = np.stack([lines.world.min(0), lines.world.max(0)]).astype(np.float64)
    maps = plan_maps((light,), bounds, Scratch(), WIDE, spacing)
    maps.build(lines, 1, Scratch())
    packed = pack_lights((light,), maps, bounds)
    if by is opacity:
        numbers = (packed, 0, maps.stacks, maps.starts, maps.sizes, maps.packed)
        return np.exp([-optical_depth(x, y, z, packed[0, 13], *numbers) for x, y, z in np.float32(points)])
    batches = np.split(points, range(W, len(points), W))
    found = np.concatenate([leave(some, loss, packed, map_arrays(maps)) for some in batches])
    return found[:, 0] if loss is None else found


def leave(
    points: NDArray[np.float64], loss: NDArray[np.float32] | None, lights: NDArray[np.float32], shadows: ShadowArrays
) -> NDArray[np.float64]:
    """(n, 3) What strands leave each point of a batch that light arrives at."""
    work = np.zeros((surface_batch.ROWS, W), np.float32)
    work[batch.X // W :][:3, : len(points)] = points.T
    work[batch.ARRIVES // W] = 1
    percentage_closer.transmittance(work.reshape(-1), len(points), lights, 0, given(loss, 4), shadows)
    return work[surface_batch.LEFT // W :][:3, : len(points)].T.astype(np.float64)


def truth_of(light: DirectionalLight | PointLight, points: NDArray[np.float64], rays: int = 256) -> NDArray[np.float64]:
    """The share of a round light that points see past the cylinders."""
    u, v = (numbers[:, None, None] for numbers in bundle(rays, 1.0, np.random.default_rng(1)).T)
    if isinstance(light, DirectionalLight):
        right, up, forward = axes(light.direction, (0.0, 1.0, 0.0))
        off = np.sin(np.radians(light.size / 2))
        ways = np.broadcast_to(-forward + off * (u * right + v * up), (rays, *points.shape)).reshape(-1, 3)
    else:
        right, up, _ = axes(-np.array(light.position), (0.0, 1.0, 0.0))
        ways = (np.array(light.position) + light.size / 2 * (u * right + v * up) - points).reshape(-1, 3)
    radii = 0.5 * WIDE.width * (1 - WIDE.taper * np.tile(np.arange(9) / 8, 1000))
    probes = np.tile(points, (rays, 1))
    left = np.zeros((len(probes), 2))
    cylinders.transmittance(
        pieces_of(LINES.first, LINES.world.astype(np.float64), radii), probes, np.full(len(probes), -1),
        frames_along(ways), np.full(len(probes), np.inf), np.zeros((2, 2)), np.ones(len(probes)), left,
    )  # fmt: skip
    return np.asarray(left.mean(1).reshape(rays, -1).mean(0))


@pytest.mark.parametrize(
    ("light", "most", "gain"),
    [(replace(SUN, size=2.0), 0.09, 0.8), (SUN, 0.04, 0.65), (replace(SUN, size=20.0), 0.025, 1.6), (LAMP, 0.07, 0.7)],
    ids=["small", "sun", "wide", "lamp"],
)
def test_shadows_on_a_ground_are_those_of_a_round_light(
    light: DirectionalLight | PointLight, most: float, gain: float
) -> None:
    """Without the filter a wide light's shadows are off by twice as much, others by a third less, but that in squares.
    A small light's show single strands, which no opacity map does."""
    x, z = np.random.default_rng(0).uniform(-1.6, 0.6, (2, 120))
    points = np.stack([x, np.full(120, -1.4), z + 0.2], 1)  # in the shadow and beside it
    truth = truth_of(light, points)
    assert 0.2 < truth.mean() < 0.9
    off, hard = left(percentage_closer, light, points) - truth, left(opacity, light, points) - truth
    assert np.abs(off).mean() < most
    assert abs(off.mean()) < 0.02
    assert np.abs(hard).mean() > gain * np.abs(off).mean()


@pytest.mark.parametrize("size", [0.0, 6.0, 30.0])
def test_nothing_shows_a_texels_side(size: float) -> None:
    """Along a line over the ground, in steps of a hundredth of a texel, no step is much larger than its neighbours."""
    light = replace(SUN, size=size)
    line = np.linspace([-1.2, -1.4, -0.1], [-0.6, -1.4, 0.0], 1501)
    soft, hard = (np.abs(np.diff(left(by, light, line), 2)).max() for by in (percentage_closer, opacity))
    assert soft < 0.1 * hard


def test_the_shadow_ends_beyond_the_maps_border() -> None:
    """A map ends a texel from the strands; a wide light's shadow goes on, and falls to nothing without a step."""
    light = replace(SUN, size=12.0)
    line = np.linspace([-2.4, -1.4, -0.4], [-0.7, -1.4, -0.4], 1201)
    found = left(percentage_closer, light, line)
    assert found[0] == 1
    assert found[-1] < 0.8
    assert np.abs(np.diff(found)).max() < 0.01


def thatch(count: int, high: float) -> Polylines:
    """A layer of strands that lie up to 5 cm above y = 0 and end at x = 0, and one strand high above their middle."""
    rng = np.random.default_rng(2)
    begin = rng.uniform([-0.6, 0.0, -0.3], [0.0, 0.05, -0.3], (count, 3))
    begin[-1] = -0.3, high, -0.3
    world = begin[:, None] + np.linspace(0, 1, 9)[:, None] * [0, 0, 0.6]
    return Polylines(np.arange(count + 1) * 9, world.astype(np.float32).reshape(-1, 3))


def test_what_touches_the_ground_has_a_sharp_shadow_whatever_is_above() -> None:
    """From a quarter of the light to three."""
    light = DirectionalLight(direction=(0.0, -1.0, 0.0), size=20.0, shadow=DEEP)
    widths = []
    for high, ground in ((0.05, -0.02), (2.0, -0.02), (2.0, -0.7)):
        line = np.linspace([-0.4, ground, 0.0], [0.4, ground, 0.0], 801)
        found = left(percentage_closer, light, line, lines=thatch(250, high), spacing=0.01)
        assert found[0] < 0.06
        assert found[-1] == 1
        widths.append(1e-3 * ((found > 0.25) & (found < 0.75)).sum())
    assert widths[0] == pytest.approx(0.02, abs=0.01)
    assert widths[1] == pytest.approx(widths[0], abs=0.005)
    assert widths[2] > 2.5 * widths[0]


@pytest.mark.parametrize("high", [2.0, 0.05, -3.0], ids=["back", "beyond", "front"])
@pytest.mark.parametrize("texel", [0.03, 0.004])
def test_an_edge_is_as_wide_as_the_light_sees_it(high: float, texel: float) -> None:
    """Wherever among the strands the ground is, and however many texels the edge goes over: at .7 m a quarter
    of a disc 20 degrees wide is hidden .0985 m from where three quarters are."""
    light = DirectionalLight(direction=(0.0, -1.0, 0.0), size=20.0, shadow=replace(DEEP, size=1024, texel=texel))
    line = np.linspace([-0.4, -0.7, 0.0], [0.4, -0.7, 0.0], 3201)
    found = left(percentage_closer, light, line, lines=thatch(2000, high), spacing=0.01)
    assert found[0] < 0.03
    assert found[-1] == 1
    assert 2.5e-4 * ((found > 0.25) & (found < 0.75)).sum() == pytest.approx(0.0985, rel=0.2)
    assert np.abs(np.diff(found)).max() < 0.006


def test_light_that_strands_scatter_on_comes_down_beside_a_shadow_that_is_far_away() -> None:
    material = Material(model="chiang", pigment="blond")
    loss = dual.loss_table(dual.build_tables(material, material.beta_n))
    light = DirectionalLight(direction=(0.0, -1.0, 0.0), shadow=DEEP)
    warm = []
    for ground in (0.0, -0.05, -0.6):
        points = np.stack([np.linspace(-0.5, -0.1, 40), np.full(40, ground - 0.01), np.zeros(40)], 1)
        grey, colours = (left(percentage_closer, light, points, one, thatch(70, 0.05), 0.02) for one in (None, loss))
        assert (colours.min(1) > grey - 1e-6).all()
        warm.append(float((colours[:, 0] - grey).mean()))
    assert warm[0] > 0.1
    assert 0.2 * warm[0] < warm[1] < 0.9 * warm[0]
    assert warm[2] < 0.15 * warm[0]


def test_nothing_in_front_of_all_strands_is_shaded_but_what_a_lamp_shades_is() -> None:
    assert (left(percentage_closer, SUN, -3 * np.array([SUN.direction])) == 1).all()
    down = DirectionalLight(direction=(0.0, -1.0, 0.0), shadow=DEEP)
    beside, under = left(percentage_closer, down, np.array([[-0.3, 1.0, 0.2], [-0.3, -0.1, 0.2]]), lines=thatch(250, 2))
    assert beside > 0.8  # a strand is above it, and all others below
    assert under < 0.1
    inside = PointLight(position=(0.1, 0.05, -0.1), size=0.02, shadow=DEEP)
    assert left(percentage_closer, inside, np.array([[0.9, -1.4, 0.8]]))[0] < 0.9
