"""Emitters: where strands grow, which way, how they bend, how long, and that nothing depends on how many there are."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from strandcli.groom.blocks import arranged
from strandcli.groom.emit import emit
from strandcli.groom.record import Groom
from strandcli.scene.model import DiscShape, Emitter, PlaneShape, SphereShape

SHAPES = [
    SphereShape(radius=0.7),
    SphereShape(radius=2.0, cap=50.0),
    DiscShape(radius=3.0),
    PlaneShape(width=2.0, depth=5.0),
]
FIELDS = ("roots", "directions", "lengths", "tones")


def grown(seed: int = 0, count: int | None = None, **settings: object) -> Groom:
    return emit(Emitter(**{"strands": 4000, **settings}), seed, count)  # type: ignore[arg-type]


@pytest.mark.parametrize("shape", SHAPES)
def test_strands_do_not_depend_on_how_many_there_are(shape: object) -> None:
    options = {"shape": shape, "jitter": 30.0, "length_variation": 0.5}
    many = grown(3, strands=5000, **options)
    for few in (grown(3, strands=777, **options), grown(3, 777, strands=5000, **options)):
        assert few.strands == 777
        for name in FIELDS:
            np.testing.assert_array_equal(getattr(few, name), getattr(many, name)[:777])
    assert grown(3, 9999, strands=20).strands == 20


def test_seeds_reproduce_and_differ() -> None:
    options = {"jitter": 30.0, "length_variation": 0.5}
    for name in FIELDS:
        first, again, other = (getattr(grown(seed, **options), name) for seed in (1, 1, 2))
        np.testing.assert_array_equal(first, again)
        assert (first != other).mean() > 0.9
    assert grown(2**63 - 1).strands == 4000  # the greatest seed


def test_roots_of_a_sphere_lie_on_it_and_point_outward() -> None:
    groom = grown(shape=SphereShape(radius=0.7))
    np.testing.assert_allclose(np.linalg.norm(groom.roots, axis=1), 0.7, rtol=1e-6)
    np.testing.assert_allclose(groom.directions, groom.roots / 0.7, atol=1e-6)


@pytest.mark.parametrize("cap", [40.0, 150.0])
def test_a_cap_is_covered_down_to_its_angle_and_no_further(cap: float) -> None:
    groom = grown(shape=SphereShape(radius=2.0, cap=cap))
    angle = np.degrees(np.arccos(np.clip(groom.roots[:, 1] / 2.0, -1, 1)))
    assert angle.max() <= cap + 0.05
    assert angle.max() > 0.97 * cap
    assert angle.min() < 0.05 * cap


def squares(shape: object, roots: np.ndarray) -> np.ndarray:
    """Roots spread over the unit square so that equal areas of the shape are equal areas there."""
    x, y, z = roots.T.astype(np.float64)
    around = np.arctan2(z, x) / (2 * np.pi) % 1.0
    if isinstance(shape, SphereShape):
        return np.stack([(1 - y / shape.radius) / (1 - np.cos(np.radians(shape.cap))), around], 1)
    if isinstance(shape, DiscShape):
        return np.stack([(x * x + z * z) / shape.radius**2, around], 1)
    assert isinstance(shape, PlaneShape)
    return np.stack([x / shape.width + 0.5, z / shape.depth + 0.5], 1)


@pytest.mark.parametrize("shape", SHAPES)
def test_every_prefix_covers_the_shape_evenly_by_area(shape: object) -> None:
    """In each of a hundred fields of equal area there are nearly as many roots; independent draws would vary by the
    root of their number."""
    count = 400
    where = squares(shape, grown(5, count, shape=shape).roots)
    counts, _, _ = np.histogram2d(*where.T, bins=10, range=[[0, 1], [0, 1]])
    assert counts.sum() == count
    assert counts.std() < 0.6 * np.sqrt(count / 100)
    assert np.abs(counts - count / 100).max() <= 0.35 * count / 100 + 2


@pytest.mark.parametrize("jitter", [60.0, 180.0])
@pytest.mark.parametrize("direction", [None, (0.0, 0.0, -1.0)])
def test_jitter_fills_its_cone_evenly_by_solid_angle(
    jitter: float, direction: tuple[float, float, float] | None
) -> None:
    groom = grown(strands=20_000, jitter=jitter, direction=direction)
    axes = groom.roots if direction is None else np.broadcast_to(np.array(direction), (20_000, 3))
    axes = axes / np.linalg.norm(axes, axis=1, keepdims=True)
    np.testing.assert_allclose(np.linalg.norm(groom.directions, axis=1), 1, atol=1e-6)
    cosine = (groom.directions * axes).sum(1)
    lowest = np.cos(np.radians(jitter))
    assert cosine.min() > lowest - 1e-6
    # by solid angle the cosine is even between the rim and the axis
    share = (1 - cosine) / (1 - lowest)
    assert np.abs(np.quantile(share, [0.25, 0.5, 0.75]) - [0.25, 0.5, 0.75]).max() < 0.015
    # and no side is preferred: the mean direction is the axis
    if direction is not None:
        mean = groom.directions.mean(0)
        np.testing.assert_allclose(mean, axes[0] * (1 + lowest) / 2, atol=0.02)


@pytest.mark.parametrize("variation", [0.0, 0.3, 1.0])
def test_lengths_are_even_between_their_limits(variation: float) -> None:
    lengths = grown(strands=20_000, length=2.0, length_variation=variation).lengths
    if variation == 0:
        assert set(lengths.tolist()) == {2.0}
        return
    low, high = 2 * (1 - variation), 2 * (1 + variation)
    assert lengths.min() >= low
    assert lengths.min() > 0
    assert lengths.max() < high
    assert abs(lengths.mean() - 2) < 0.02
    quarters = low + (high - low) * np.array([0.25, 0.5, 0.75])
    np.testing.assert_allclose(np.quantile(lengths, [0.25, 0.5, 0.75]), quarters, atol=0.02 * (high - low))


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**63 - 1),
    shape=st.sampled_from(SHAPES),
    scale=st.sampled_from([1e-9, 1e-3, 1.0, 1e9]),
    jitter=st.floats(0, 180),
    variation=st.floats(0, 1),
    strands=st.integers(1, 200),
)
def test_everything_that_is_emitted_is_a_finite_strand(
    seed: int, shape: object, scale: float, jitter: float, variation: float, strands: int
) -> None:
    names = [f.name for f in dataclasses.fields(shape) if f.name not in ("kind", "cap")]  # type: ignore[arg-type]
    sizes = {name: getattr(shape, name) * scale for name in names}
    groom = grown(
        seed, strands=strands, shape=dataclasses.replace(shape, **sizes), jitter=jitter, length_variation=variation,  # type: ignore[type-var]
        length=scale,
    )  # fmt: skip
    assert groom.roots.shape == groom.directions.shape == (strands, 3)
    for name in FIELDS:
        assert getattr(groom, name).dtype == np.float32
        assert np.isfinite(getattr(groom, name)).all()
    assert (groom.lengths > 0).all()
    np.testing.assert_allclose(np.linalg.norm(groom.directions, axis=1), 1, atol=1e-6)


def test_combed_strands_lie_along_the_surface_toward_the_comb() -> None:
    settings = {"shape": SphereShape(radius=1.0), "comb": (0.0, 0.0, -2.0), "lift": 20.0}
    groom = grown(1, strands=5000, **settings)
    np.testing.assert_allclose(np.linalg.norm(groom.directions, axis=1), 1, atol=1e-6)
    normals = groom.roots
    open_ = np.linalg.norm(np.cross(normals, [0, 0, 1.0]), axis=1) > 0.3
    lifted = np.degrees(np.arcsin((groom.directions * normals).sum(1)))
    np.testing.assert_allclose(lifted[open_], 20, atol=0.3)
    along = np.array([0, 0, -1.0]) + normals[:, 2:] * normals
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    np.testing.assert_allclose((groom.directions * along).sum(1)[open_], np.cos(np.radians(20)), atol=0.01)
    flat = grown(1, lift=90.0, **{k: v for k, v in settings.items() if k != "lift"})
    np.testing.assert_allclose(flat.directions, flat.roots, atol=2e-3)
    assert (groom.directions * normals).sum(1).min() > 0, "no strand grows inward"


def test_a_parting_combs_away_from_itself_in_front_and_not_at_all_behind() -> None:
    groom = grown(1, strands=8000, shape=SphereShape(radius=1.0), comb=(1.0, 0.0, 0.0), parting=0.1, lift=30.0)
    x, _, z = groom.roots.T
    top = (np.abs(x - 0.1) < 0.3) & (groom.roots[:, 1] > 0.3)
    for side, sign in ((x > 0.1, 1), (x < 0.1, -1)):
        assert (sign * groom.directions[side & top & (z > 0.3), 0] > 0.3).all()
    behind = z < -0.3
    tangential = groom.directions - (groom.directions * groom.roots).sum(1)[:, None] * groom.roots
    assert np.abs(tangential[behind]).max() < 1e-5


ON_A_BALL = {"shape": SphereShape(radius=0.5), "strands": 300, "comb": (0.3, -1.0, 0.2), "lift": 40.0}


def angles(bend: float, onset: float) -> tuple[np.ndarray, np.ndarray]:
    """Degrees by which edges (20,) of strands turn to their inward side, and by how much they leave that plane."""
    groom = arranged(emit(Emitter(**ON_A_BALL, bend=bend, bend_onset=onset), 1))
    axes = groom.directions.astype(float)
    normals = groom.roots / 0.5
    side = np.cross(axes, normals)
    side /= np.linalg.norm(side, axis=1)[:, None]
    inward = np.cross(axes, side)
    assert ((inward * normals).sum(1) < 0).all()
    edges = np.array([groom.edge(j, 20) for j in range(20)])
    turned = np.degrees(np.arctan2((edges * inward).sum(2), (edges * axes).sum(2)))
    np.testing.assert_allclose(np.linalg.norm(edges, axis=2), 1, atol=1e-6)
    return turned, np.abs((edges * side).sum(2))


def test_strands_turn_evenly_from_the_onset_on() -> None:
    turned, aside = angles(80.0, 0.5)
    middles = (np.arange(20) + 0.5) / 20
    np.testing.assert_allclose(
        turned, np.broadcast_to(160 * np.maximum(middles - 0.5, 0)[:, None], (20, 300)), atol=1e-3
    )
    assert aside.max() < 1e-6
