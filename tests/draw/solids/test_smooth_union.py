"""Solids that run into each other: one smooth surface, met by rays, with its normals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from strand_kit import frames_of, scene_of
from strandcli.constants import W
from strandcli.draw.solids.kernels import rays, smooth_union, sphere_tracing
from strandcli.draw.solids.solids import packed
from strandcli.scene.model import CapsuleSolid, Emitter, SphereSolid

SCENE = """
emitter: {{strands: 1, length: 0.01, shape: {{kind: sphere, radius: 0.01}}}}
solids:
  - {{kind: sphere, radius: 0.5, position: [-0.4, 0, 0], colour: [0.5, 0.5, 0.5]{blend}}}
  - {{kind: sphere, radius: 0.5, position: [0.4, 0, 0], colour: [0.5, 0.5, 0.5]{blend}}}
camera: {{position: [0, 0, 4]{kind}}}
ambient: [0, 0, 0]
lights: [{{kind: directional, direction: [-1, 0, -1], shadow: {{model: "off"}}}}]
image: {{size: 96x64, resolver: sorted, background: [0, 0, 1]}}
"""


def group(blend: float, *more: SphereSolid | CapsuleSolid) -> list[NDArray[np.float32]]:
    pair = [SphereSolid(radius=0.5, position=(x, 0.0, 0.0), blend=blend) for x in (-0.4, 0.4)]
    return packed([*pair, *more], Emitter(), 0.0)


def met(solid: list[NDArray[np.float32]], origin: tuple[float, ...], way: tuple[float, ...]) -> float:
    return float(smooth_union.meet(*solid[:2], *np.array([*origin, *way], np.float32)))


def met_together(solid: list[NDArray[np.float32]], origins: NDArray[np.float32], ways: NDArray[np.float32]) -> Any:
    """Where rays (n, 3) meet it, many at once."""
    found = []
    for low in range(0, len(origins), W):
        count = len(origins[low : low + W])
        work = np.zeros((sphere_tracing.ROWS, W), np.float32)
        for c in range(3):
            work[sphere_tracing.OX // W + c, :count] = origins[low : low + W, c]
            work[sphere_tracing.DX // W + c, :count] = ways[low : low + W, c]
        sphere_tracing.meet(work.reshape(-1), count, *solid[:2])
        found.append(work[sphere_tracing.MET // W, :count].copy())
    return np.concatenate(found)


def far(solid: list[NDArray[np.float32]], point: NDArray[np.float64], k: float = 0.04) -> float:
    """Distance from the surface."""
    return float(smooth_union.surface(*solid[:2], smooth_union.EVERY, np.float32(k), *point.astype(np.float32))[0])


def test_far_from_a_seam_the_surface_is_the_solids_own() -> None:
    pair = group(0.02)
    assert met(pair, (-3, 0, 0), (1, 0, 0)) == pytest.approx(2.1, abs=1e-3)
    assert met(pair, (-3, 0, 0), (2, 0, 0)) == pytest.approx(1.05, abs=1e-3)  # in units of |d|
    assert np.isinf(met(pair, (0, 3, 0), (1, 0, 0)))
    assert np.isinf(met(pair, (-3, 0, 0), (-1, 0, 0)))
    assert np.isinf(met(pair, (-0.4, 0, 0), (1, 0, 0)))


@pytest.mark.parametrize("k", [0.01, 0.05, 0.1])
def test_halfway_between_two_balls_the_distance_is_less_by_k_ln_2(k: float) -> None:
    pair = group(k)
    t = met(pair, (0, 3, 0), (0, -1, 0))
    own = np.hypot(0.4, 3 - t) - 0.5
    assert own == pytest.approx(k * np.log(2), abs=0.05 * k)
    nx, ny, nz = smooth_union.normal(*pair[:2], *np.array([0, 3 - t, 0], np.float32))
    assert (nx, ny, nz) == pytest.approx((0, 1, 0), abs=1e-4)


def test_normals_are_the_gradient_and_turn_without_a_crease() -> None:
    bar = CapsuleSolid(radius=0.2, length=0.8, position=(0.0, 0.3, 0.2), rotation=(20.0, 0.0, 30.0), blend=0.04)
    solid = group(0.04, bar)
    last = None
    off = []
    for x in np.linspace(-0.7, 0.7, 281):
        t = met(solid, (x, 0.05, 4), (0, 0, -1))
        point = np.array([x, 0.05, 4 - t])
        normal = np.array(smooth_union.normal(*solid[:2], *point.astype(np.float32)))
        assert np.linalg.norm(normal) == pytest.approx(1, abs=1e-5)
        h = 2e-3
        sides = [[far(solid, point + side * h * axis) for side in (1, -1)] for axis in np.eye(3)]
        step = np.subtract(*np.transpose(sides))
        off.append(float(np.abs(normal - step / np.linalg.norm(step)).max()))
        if last is not None:
            assert normal @ last > 0.99
        last = normal
    assert np.median(off) < 0.005
    # a solid is left out where it would count e^-6 of the nearest: k e^-6 / 2h
    assert max(off) < 0.03


def test_many_rays_at_once_are_met_as_each_alone() -> None:
    """Rays from without and from within, into the surface and past it, and a batch that is not full: where the surface
    begins for both is within a twenty-fifth of the way of blending."""
    k = 0.05
    solid = group(k, CapsuleSolid(radius=0.2, length=0.8, position=(0.0, 0.5, 0.1), blend=k))
    generator = np.random.default_rng(4)
    origins = generator.normal(size=(500, 3)).astype(np.float32)
    ways = (generator.normal(size=(500, 3)) * [0.5, 0.5, 0.5] - origins).astype(np.float32)
    ways *= generator.uniform(0.3, 3.0, (500, 1)).astype(np.float32)
    together = met_together(solid, origins, ways)
    alone = np.array([met(solid, tuple(o), tuple(w)) for o, w in zip(origins, ways, strict=True)])
    hit = np.isfinite(alone)
    assert (np.isfinite(together) == hit).all()
    assert 100 < hit.sum() < 450
    apart = np.abs(together[hit] - alone[hit]) * np.linalg.norm(ways[hit], axis=1)
    assert apart.max() < smooth_union.NEAR * k
    for o, w, t in zip(origins[hit], ways[hit], together[hit], strict=True):
        assert abs(far(solid, (o + t * w).astype(np.float64), k)) < 1.1 * smooth_union.NEAR * k


def test_solids_without_the_column_do_not_blend() -> None:
    plain = group(0.0)
    assert not smooth_union.blends.py_func(*plain[:2], np.int64(0))
    bare = [rows[:, :-1].copy() for rows in plain[:2]]
    assert not smooth_union.blends.py_func(*bare, np.int64(1))
    assert rays.meet(plain, np.int64(0), *np.array([-3, 0, 0, 1, 0, 0], np.float32)) == pytest.approx(2.1)


def crease(blend: str, kind: str = "") -> float:
    """The greatest change of light from one pixel to the next across the seam."""
    image = frames_of(scene_of(SCENE.format(blend=blend, kind=kind)), 1)[0].image.astype(float)
    row = image[32, 36:60, 1]
    return float(np.abs(np.diff(row)).max())


@pytest.mark.parametrize("kind", ["", ", kind: orthographic, height: 2.3"])
def test_pictures_have_no_crease(kind: str) -> None:
    assert crease(", blend: 0.05", kind) < 0.4 * crease("", kind)


def test_the_edge_of_a_group_is_antialiased_and_has_no_holes() -> None:
    image = frames_of(scene_of(SCENE.format(blend=", blend: 0.05", kind="")), 1)[0].image
    inside = image[..., 2].astype(int) - image[..., 0].astype(int)
    covered = inside < 128
    for row in covered[29:36]:
        there = np.flatnonzero(row)
        assert len(there) == there[-1] - there[0] + 1


FOLDED = """
emitter: {{strands: 1, length: 0.01, shape: {{kind: sphere, radius: 0.01}}}}
rules: []
solids:
  - {{kind: sphere, radius: 0.5, position: [-0.3, 0, 0.8], colour: [1, 1, 1], blend: 0.01}}
  - {{kind: sphere, radius: 0.6, position: [0.3, 0, -0.8], colour: [1, 1, 1], blend: 0.01}}
camera: {{position: [0, 0, 4]{kind}}}
ambient: [0, 0, 0]
lights: [{{kind: directional, direction: [-0.3, 0, -1], intensity: 3, shadow: {{model: "off"}}}}]
image: {{size: {size}, resolver: {resolver}, background: [0, 0, 0]}}
"""


@pytest.mark.parametrize("kind", ["", ", kind: orthographic, height: 2"])
def test_where_what_blends_ends_in_front_of_itself_the_edge_is_smooth(kind: str) -> None:
    """Against eight by eight samples of the same surface: the dim limb of the near ball before the lit one, which rays
    reach that graze the near one."""
    linear = []
    for size, resolver in (("96x64", "sorted"), ("768x512", "zbuffer")):
        image = frames_of(scene_of(FOLDED.format(kind=kind, size=size, resolver=resolver)), 1)[0].image
        assert image is not None
        light = (image[..., 0].astype(float) / 255) ** 2.2
        linear.append(light if size == "96x64" else light.reshape(64, 8, 96, 8).mean((1, 3)))
    got, exact = linear
    steep = np.abs(exact[:, 2:] - exact[:, :-2]) > 0.2
    off = np.abs(got - exact)
    assert steep.sum() > 100
    assert off.max() < 0.1  # 0.6 with one ray a pixel
