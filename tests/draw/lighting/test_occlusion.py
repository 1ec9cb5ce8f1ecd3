"""Ambient occlusion: the grid against closed forms and against rays that meet cylinders, and the light that is left."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from strand_kit import frames_of, scene_of
from strandcli.constants import W
from strandcli.draw.common.kernels import batch
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.geometry.extent import Thickness
from strandcli.draw.lighting import occlusion
from strandcli.draw.lighting.kernels import light
from strandcli.draw.lighting.kernels.inputs import Surround
from strandcli.draw.solids.kernels import rays
from strandcli.groom.blocks import pack
from strandcli.jit import function
from strandcli.plan import make_plan
from strandcli.scene.model import AmbientOcclusion, DirectionalLight, Emitter, PlaneSolid, SphereSolid
from strandcli.solids import pack_all
from strandcli.study.pictures.shadow import transmittance

BOX = np.array([[-1.0, -1, -1], [1, 1, 1]])
HAIR = """
emitter: {shape: {kind: sphere, radius: 0.5}, strands: 3000, particles: 4, length: 0.3}
solids: [{kind: sphere, radius: 0.49}]
lights: []
ambient: [1, 1, 1]
camera: {position: [0, 0, 4]}
material: {colour: [0.3, 0.3, 0.3], width: 0.006}
image: {size: 48x48, resolver: sorted, background: [0, 0, 0]}
"""


def strands(points: NDArray[np.float64]) -> NDArray[np.float32]:
    """Strands (S, n, 3) as drivers take them, with a row before the root."""
    return pack(np.concatenate([2 * points[:, :1] - points[:, 1:2], points], 1).astype(np.float32))


def thicket(count: int, seed: int = 0) -> NDArray[np.float64]:
    """Straight strands in all directions about the middle, (count, 4, 3)."""
    rng = np.random.default_rng(seed)
    begin = rng.normal(scale=0.25, size=(count, 1, 3)).clip(-0.6, 0.6)
    way = rng.normal(size=(count, 1, 3))
    way /= np.linalg.norm(way, axis=2, keepdims=True)
    return begin + 0.3 * way * np.linspace(0, 1, 4)[:, None]


def built(
    points: NDArray[np.float64], width: float, solids: tuple[object, ...] = (), **settings: int
) -> occlusion.Occlusion:
    packed = pack_all(solids, Emitter(), 0.0) if solids else None
    return occlusion.build(
        AmbientOcclusion(**settings), strands(points), len(points), BOX, Thickness(width), None, packed, Scratch()
    )


def test_surfaces_see_their_half_of_the_sky() -> None:
    floor = PlaneSolid(position=(0.0, -0.5, 0.0))
    found = built(thicket(4), 1e-6, (floor,), directions=64)
    points = np.array([[0.3, -0.5, 0.1], [-0.4, -0.5, 0.0], [9.0, -0.5, 3.0]])
    up = np.tile([0.0, 1.0, 0.0], (3, 1))
    assert found.at(points, up) == pytest.approx(1.0, abs=0.02)
    assert found.at(points[:2]) == pytest.approx(0.5, abs=0.01)


def test_a_ball_hides_its_share_of_the_sky() -> None:
    # cells far from strands and surfaces ask for no solids: a strand leads away from the ball
    ball = SphereSolid(radius=0.3)
    away = np.array([[[x, 0.0, 0.0] for x in np.linspace(0.31, 1.0, 30)]])
    found = built(away, 1e-6, (ball,), directions=256, cells=200_000)
    for distance in (0.4, 0.6, 0.9):
        truth = 0.5 * (1 + np.sqrt(1 - (0.3 / distance) ** 2))
        assert found.at(np.array([[distance, 0.0, 0.0]]))[0] == pytest.approx(truth, abs=0.02)


def test_parallel_strands_let_light_through_along_them() -> None:
    x, z = np.meshgrid(np.linspace(-0.9, 0.9, 40), np.linspace(-0.9, 0.9, 40))
    comb = np.stack([np.stack([x.ravel(), np.full(1600, y), z.ravel()], 1) for y in np.linspace(-0.9, 0.9, 5)], 1)
    found = built(comb, 0.01, directions=256)
    middle = np.array([[0.0, 0.0, 0.0]])
    v = found.volume.reshape(*found.box[6:9].astype(int), 4)
    assert found.at(middle) < 0.35
    # at the top all that is seen lies above, and above all is open
    top = found.at(np.array([[0.0, 0.9, 0.0]]), np.array([[0.0, 1.0, 0.0]]))
    assert top > 0.85
    assert np.isfinite(v).all()


# of a few thick strands each one's own shadow counts, and a cell knows no more than the mean of what is in it
@pytest.mark.parametrize(("count", "width", "mean"), [(500, 0.02, 0.05), (3000, 0.008, 0.03)])
def test_against_rays_that_meet_cylinders(count: int, width: float, mean: float) -> None:
    points = thicket(count)
    solids = (SphereSolid(radius=0.2, position=(0.0, 0.2, 0.1)),)
    packed = pack_all(solids, Emitter(), 0.0)
    lines = Polylines(np.arange(count + 1) * 4, points.reshape(-1, 3).astype(np.float32))
    own = np.random.default_rng(1).permutation(count)[:60]
    own = own[np.linalg.norm(points[own, 2] - [0.0, 0.2, 0.1], axis=1) > 0.22]
    probes = points[own, 2]
    angle = 2 * np.pi * np.arange(6) / 6
    jitter = 0.03 * np.stack([np.cos(angle), np.sin(angle)], 1)
    truth = np.zeros(len(probes))
    for direction in occlusion.directions(64):
        light = DirectionalLight(direction=tuple((-direction).tolist()))
        left = transmittance(lines, Thickness(width), light, probes, own, jitter, np.ones(len(probes))).mean(1)
        for p, point in enumerate(probes.astype(np.float32)):
            left[p] *= rays.visibility(
                packed, *point, *direction.astype(np.float32), np.float32(1e30), np.float32(1e-3)
            )
        truth += left / 64
    off = built(points, width, solids).at(probes) - truth
    assert np.abs(off).mean() < mean
    assert abs(off.mean()) < 0.02
    assert 0.1 < truth.mean() < 0.8


@function
def ambient_light(work: Any, around: Any) -> None:
    light.ambient_light(work, np.int64(1), around)


def lit(share: float, colour: float) -> float:
    """Radiance in a sky of 1 of a strand that sees this share of it."""
    work = np.zeros(batch.ROWS * W, np.float32)
    work[batch.COLOUR : batch.COLOUR + 3 * W] = colour
    volume = np.tile(np.array([share, 0, 0, 0], np.float32), (8, 1))
    box = np.array([-1, -1, -1, 0.5, 0.5, 0.5, 2, 2, 2, 1], np.float32)
    no_sky = np.zeros((0, 9, 3), np.float32)
    around = Surround(np.ones(3, np.float32), no_sky, volume, box)
    ambient_light(work, around)
    return float(work[batch.RADIANCE])


def test_a_mass_keeps_its_colour_and_white_strands_lose_no_light() -> None:
    for colour in (0.03, 0.3, 0.8):
        assert lit(float(light.FACE), colour) == pytest.approx(colour, rel=1e-5)
        assert lit(0.02, colour) < colour < lit(0.6, colour) < 1
    assert lit(0.3, 1.0) == pytest.approx(1.0)
    assert lit(0.0, 1.0) == 0
    assert lit(0.02, 0.05) / 0.05 < lit(0.02, 0.5) / 0.5


def picture(extra: str = "") -> NDArray[np.uint8]:
    return frames_of(scene_of(HAIR + extra), 1)[0].image


def test_pictures_show_it_where_they_ask_for_it() -> None:
    flat, deep = picture().astype(float), picture("ambient_occlusion: {}\n").astype(float)
    share = deep[flat > 20] / flat[flat > 20]
    assert share.min() < 0.8 * np.median(share)
    assert share.max() > 1.1 * np.median(share)


def test_left_out_where_there_is_nothing_to_occlude() -> None:
    dark = scene_of(HAIR.replace("[1, 1, 1]", "[0, 0, 0]") + "ambient_occlusion: {}\n")
    assert not dark.occluded
    assert not scene_of(HAIR).occluded
    assert scene_of(HAIR + "ambient_occlusion: {cells: 5000}\n").occluded
    assert "ambient occlusion" in {stage.stage for stage in make_plan(dark, [1]).left_out}


def test_far_from_the_origin_strands_in_one_place_have_a_grid() -> None:
    """A million kilometres off, single precision knows no metres."""
    points = thicket(5) + np.array([1e9, 2e9, -1e9])
    packed = strands(points)
    where = points.astype(np.float32).astype(np.float64).reshape(-1, 3)
    bounds = np.stack([where.min(0), where.max(0)])
    found = occlusion.build(AmbientOcclusion(), packed, 5, bounds, Thickness(0.01), None, None, Scratch())
    assert np.isfinite(found.box).all()
    assert (found.box[6:9] >= occlusion.FEWEST).all()
    assert ((found.volume[:, 0] >= 0) & (found.volume[:, 0] <= 1.01)).all()
