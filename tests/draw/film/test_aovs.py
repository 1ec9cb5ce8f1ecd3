"""Layers beside the picture, of lines and of sorted strands, against closed forms: straight strands, planes, balls."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from strand_kit import frames_of, scene_of
from strandcli.draw.film.aovs import NOTHING, SOLID
from strandcli.draw.view.camera import camera_view
from strandcli.run.frame import Frame
from strandcli.scene import Scene
from strandcli.scene.model import AOVS

# strands of 2 m side by side in a plane through the origin, without any rule
SHEET = """
emitter: {strands: %d, particles: 2, length: 2, direction: %s, position: %s,
  shape: {kind: plane, width: %g, depth: 0.000001}}
rules: []
camera: {kind: %s, position: [0.3, 0.2, 4], target: [0.1, 0, 0], fov: 30, height: 2}
image: {size: [64, 48], background: [0.2, 0.3, 0.4], supersample: %d,
  aovs: [depth, mask, solid, tangent, orientation, strand_id, shadow, linear]}
curves: {mode: "off"}
material: {specular: 0, diffuse: 0.5, colour: [0.6, 0.4, 0.2]}
lights: %s
solids: %s
"""
KINDS = pytest.mark.parametrize("kind", ["perspective", "orthographic"])


def by_coverage(text: str, wide: float) -> str:
    """The scene of strands of true widths, sorted."""
    text = text.replace("image: {", "image: {resolver: sorted, ")
    return text.replace("material: {", f"material: {{width: {wide:g}, ")


def drawn(
    strands: int = 300, direction: tuple[float, ...] = (0, 1, 0), position: tuple[float, ...] = (0, -1, 0),
    width: float = 1.0, kind: str = "perspective", samples: int = 1, lights: str = "[]", solids: str = "[]",
    wide: float | None = None,
) -> tuple[Scene, Frame]:  # fmt: skip
    """A scene and its frame; by true coverage of strands so ``wide``, or of lines."""
    text = SHEET % (strands, list(direction), list(position), width, kind, samples, lights, solids)
    scene = scene_of(text if wide is None else by_coverage(text, wide))
    return scene, frames_of(scene, 1)[0]


def rays(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Origins and directions (48, 64, 3) of the pixels' rays, the directions with a depth of one."""
    view = camera_view(scene.camera, 0.0, 64, 48, np.array([[-1.0, -1, -1], [1, 1, 1]]))
    y, x = np.mgrid[:48, :64] + 0.5
    across = (x - 32)[..., None] / view.focal * view.right + (24 - y)[..., None] / view.focal * view.up
    if view.perspective:
        return np.broadcast_to(view.eye, across.shape), view.forward + across
    return view.eye + across, np.broadcast_to(view.forward, across.shape)


def seen_angle(scene: Scene, tangent: np.ndarray) -> np.ndarray:
    """(48, 64) the projected angle of a direction, by moving a little along it from a point on each ray."""
    view = camera_view(scene.camera, 0.0, 64, 48, np.array([[-1.0, -1, -1], [1, 1, 1]]))
    origin, way = rays(scene)
    places = []
    for step in (-1e-4, 1e-4):
        v = origin + 4 * way + step * tangent - view.eye
        scale = 1 / (v @ view.forward) if view.perspective else 1.0
        places.append(np.stack([(v @ view.right) * scale, (v @ view.up) * scale], -1))
    dx, dy = np.moveaxis(places[1] - places[0], -1, 0)
    return np.asarray(np.arctan2(dy, dx) % np.pi)


@KINDS
def test_depth_of_a_sheet_of_strands_is_that_of_its_plane(kind: str) -> None:
    for direction in ((0.0, 1.0, 0.0), (0.0, 0.8, -0.6)):
        scene, frame = drawn(2000, direction, kind=kind)
        depth, ids = frame.aovs["depth"], frame.aovs["strand_id"]
        assert depth.dtype == np.float32
        there = ids >= 0
        assert there.sum() > 500
        origin, way = rays(scene)
        normal = np.cross(direction, [1, 0, 0])
        exact = ((np.array([0, -1, 0]) - origin) @ normal) / (way @ normal)
        # a line is sampled where it crosses the pixel's row: aside of the centre by half a pixel, in a plane that
        # leans to the camera's sides a little
        assert np.abs(depth - exact)[there].max() < 0.004
        assert (depth[ids == NOTHING] == np.inf).all()


@KINDS
@pytest.mark.parametrize(
    "direction", [(0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (-1.0, 1.0, 0.0), (0.3, 1.0, 0.9), (0.5, -1.0, -2.0)]
)
def test_tangents_and_orientations_of_straight_strands(kind: str, direction: tuple[float, ...]) -> None:
    unit = np.array(direction) / np.linalg.norm(direction)
    scene, frame = drawn(400, direction, tuple((-unit).tolist()), kind=kind)
    there = frame.aovs["strand_id"] >= 0
    assert there.sum() > 40  # along x they all lie in one line
    np.testing.assert_allclose(frame.aovs["tangent"][there], np.broadcast_to(unit, (there.sum(), 3)), atol=1e-5)
    assert (frame.aovs["tangent"][~there] == 0).all()
    angle = frame.aovs["orientation"]
    assert (angle[~there] == -1).all()
    assert angle[there].min() >= 0
    assert angle[there].max() < np.pi
    off = np.abs(angle - seen_angle(scene, unit))[there]
    assert np.minimum(off, np.pi - off).max() < 1e-3


@KINDS
@pytest.mark.parametrize("samples", [1, 3])
def test_ids_of_one_strand_and_what_is_none(kind: str, samples: int) -> None:
    ball = "[{kind: sphere, radius: 0.3, position: [0.6, 0, 0]}]"
    _, frame = drawn(1, width=1e-6, kind=kind, samples=samples, solids=ball)
    ids = frame.aovs["strand_id"]
    assert ids.dtype == np.int32
    assert set(np.unique(ids)) == {NOTHING, SOLID, 0}
    assert 40 < np.count_nonzero(ids == 0) < 100
    assert np.isfinite(frame.aovs["depth"][ids == SOLID]).all()
    assert frame.aovs["depth"][ids == SOLID].min() > 3.6


def test_ids_are_those_of_the_groom_whatever_else_is_drawn() -> None:
    """Where a pixel has a strand's number there is that strand, by its root."""
    scene, frame = drawn(12)
    ids = frame.aovs["strand_id"]
    roots = frame.positions[:, 0]
    origin, way = rays(scene)
    depth = np.where(np.isfinite(frame.aovs["depth"]), frame.aovs["depth"], 0)
    place = origin + depth[..., None] * way
    there = ids >= 0
    found = set(np.unique(ids[there]).tolist())
    assert len(found) > 6  # some stand behind another within a pixel
    assert found < set(range(12)) or found == set(range(12))
    assert np.abs(place[there][:, 0] - roots[ids[there], 0]).max() < 0.04  # half a pixel is 0.02


@pytest.mark.parametrize("samples", [1, 4])
def test_the_mask_is_the_share_of_the_picture_that_is_not_background(samples: int) -> None:
    """One colour on one background: the picture itself is the mask."""
    _, frame = drawn(60, samples=samples)
    mask, linear = frame.aovs["mask"], frame.aovs["linear"]
    strand = np.array([0.6, 0.4, 0.2]) * 0.1  # ambient
    background = np.array([0.2, 0.3, 0.4])
    np.testing.assert_allclose(linear, background + mask[..., None] * (strand - background), atol=1e-6)
    assert (mask > 0).any()
    assert ((mask > 0) == (frame.aovs["strand_id"] >= 0)).all()
    assert len(np.unique(mask)) > (1 if samples == 1 else 6)


def test_the_shadow_is_the_share_of_light_that_solids_leave() -> None:
    """Two suns of irradiance 3 and 1 (by luminance); a wall hides the first from the lower half."""
    suns = (
        "[{kind: directional, direction: [1, 0, 0], intensity: 3, shadow: {model: 'off'}},"
        " {kind: directional, direction: [-1, 0, 0], intensity: 1, shadow: {model: 'off'}}]"
    )
    wall = "[{kind: box, size: [0.1, 4, 4], position: [-3, -2, 0]}]"
    scene, frame = drawn(300, lights=suns, solids=wall)
    there = frame.aovs["strand_id"] >= 0
    origin, way = rays(scene)
    height = (origin + np.where(there, frame.aovs["depth"], 0)[..., None] * way)[..., 1]
    shadow = frame.aovs["shadow"]
    np.testing.assert_allclose(shadow[there & (height > 0.02)], 1)
    np.testing.assert_allclose(shadow[there & (height < -0.02)], 0.25)
    assert (shadow[frame.aovs["strand_id"] == NOTHING] == 1).all()
    _, free = drawn(300, lights=suns)
    assert (free.aovs["shadow"] == 1).all()


def test_under_a_thin_sheet_solids_have_the_light_that_it_lets_through() -> None:
    """Parallel strands 1 mm wide, 300 a metre: τ is .3, none of which is a point's own as on a strand."""
    sun = "[{kind: directional, direction: [0, -1, 0], shadow: {model: opacity}}]"
    text = SHEET % (300, [0, 0, 1], [0, 0, -1], 1, "perspective", 1, sun, "[{kind: plane, position: [0, -0.5, 0]}]")
    text = text.replace("[0.3, 0.2, 4]", "[0, 3, 3]").replace("{specular: 0", "{width: 0.001, taper: 0, specular: 0")
    scene = scene_of(text)
    frame = frames_of(scene, 1)[0]
    origin, way = rays(scene)
    place = origin + np.nan_to_num(frame.aovs["depth"], posinf=0)[..., None] * way
    under = (frame.aovs["strand_id"] == SOLID) & (abs(place[..., 0]) < 0.4) & (abs(place[..., 2] - 0.7) < 0.2)
    assert under.sum() > 20
    assert np.mean(frame.aovs["shadow"][under]) == pytest.approx(np.exp(-0.3), abs=0.005)


@pytest.mark.parametrize("resolver", ["zbuffer", "sorted"])
@pytest.mark.parametrize("samples", [1, 3])
def test_solids_are_where_rays_meet_them_behind_strands_too(resolver: str, samples: int) -> None:
    text = SHEET % (400, [0, 1, 0], [0, -1, 0.5], 1, "perspective", samples, "[]", "[{kind: sphere, radius: 0.4}]")
    scene = scene_of(text.replace("image: {", f"image: {{resolver: {resolver}, "))
    found = frames_of(scene, 1)[0].aovs
    origin, way = rays(scene)
    along = (way * -origin).sum(-1) / (way * way).sum(-1)
    apart = np.linalg.norm(origin + along[..., None] * way, axis=-1)
    reach = 4 * math.sqrt(0.5) * math.tan(math.radians(15)) / 24  # from a pixel's middle to its corner
    assert (found["solid"][apart < 0.4 - 1.1 * reach] == 1).all()
    assert (found["solid"][apart > 0.4 + 1.1 * reach] == 0).all()
    assert ((found["solid"] > 0) & (found["strand_id"] >= 0)).sum() > 50
    assert ((found["solid"] > 0) & (found["solid"] < 1)).sum() > 10


@settings(max_examples=8, deadline=None)
@given(st.lists(st.sampled_from(AOVS), unique=True, max_size=4))
def test_layers_that_are_asked_for_are_there_and_the_picture_stays(names: list[str]) -> None:
    text = SHEET % (60, [0, 1, 0], [0, -1, 0], 1, "perspective", 1, "[]", "[]")
    listed = "[depth, mask, solid, tangent, orientation, strand_id, shadow, linear]"
    frame = frames_of(scene_of(text.replace(listed, str(names))), 1)[0]
    assert list(frame.aovs) == names
    np.testing.assert_array_equal(frame.image, drawn(60)[1].image)


CROP = "[9, 5, 31, 22]"


@KINDS
@pytest.mark.parametrize("samples", [1, 2])
def test_a_crop_window_is_a_part_of_the_whole_picture(kind: str, samples: int) -> None:
    """But for lines whose place on the screen rounds otherwise: they may step from row to row a pixel earlier."""
    suns = "[{kind: directional, direction: [1, -1, -1], shadow: {size: 64}}]"
    solids = "[{kind: sphere, radius: 0.3, position: [0.2, 0, 0]}, {kind: plane, position: [0, -0.6, 0]}]"
    text = SHEET % (100, [0.3, 1, 0], [0, -1, 0], 1, kind, samples, suns, solids)
    text = text.replace("supersample", "horizon: [0, 0.5, 1], supersample")
    whole, part = (
        frames_of(scene_of(one), 1)[0] for one in (text, text.replace("supersample", f"crop: {CROP}, supersample"))
    )
    assert part.image.shape == (22, 31, 3)
    window = (slice(5, 27), slice(9, 40))
    differ = (whole.image[window] != part.image).any(2)
    assert differ.mean() < 0.01
    for name in ("depth", "strand_id", "mask", "orientation"):
        assert (~np.isclose(whole.aovs[name][window], part.aovs[name], atol=1e-4)).mean() < 0.01


@KINDS
@pytest.mark.parametrize("samples", [1, 2])
@pytest.mark.parametrize("wide", [0.001, 0.2])
def test_layers_of_sorted_strands_tell_what_their_picture_shows(kind: str, samples: int, wide: float) -> None:
    """The mask is the exact share of the picture that is not background, however thin the strands; the rest is that of
    a strand that is there."""
    scene, frame = drawn(40, kind=kind, samples=samples, wide=wide)
    mask, linear, ids = frame.aovs["mask"], frame.aovs["linear"], frame.aovs["strand_id"]
    strand = np.array([0.6, 0.4, 0.2]) * 0.1  # ambient
    background = np.array([0.2, 0.3, 0.4])
    np.testing.assert_allclose(linear, background + mask[..., None] * (strand - background), atol=2e-6)
    assert len(np.unique(mask)) > 40
    # a sheet of strands of one direction: both as exact as ever
    there = ids >= 0
    assert (mask[there] >= 1 / 64 / samples**2).all()
    assert there[mask >= 1 / 64 + 1e-6].all() if samples == 1 else there[mask >= 0.1].all()
    origin, way = rays(scene)
    exact = ((np.array([0, -1, 0]) - origin) @ [0, 0, 1.0]) / (way @ [0, 0, 1.0])
    # a fragment has the depth of its strand's middle, in a plane that leans to the camera's sides by 1/20
    assert np.abs(frame.aovs["depth"] - exact)[there].max() < 0.005 + wide / 20
    np.testing.assert_allclose(frame.aovs["tangent"][there], np.broadcast_to([0, 1, 0], (there.sum(), 3)), atol=1e-5)
    place = origin + np.where(there, frame.aovs["depth"], 0)[..., None] * way
    reach = wide / 2 + 0.02 * (2 - 1 / samples)  # and as far as a sample's border is from the pixel's middle
    assert np.abs(place[there][:, 0] - frame.positions[ids[there], 0, 0]).max() < reach


def test_a_sorted_pixel_is_that_of_the_strand_that_shows_most() -> None:
    """Thin strands before a wide one that they hardly cover, and a ball that shows between and beside them."""
    ball = "[{kind: sphere, radius: 0.4, position: [0.3, 0, -0.5]}]"
    for wide, holds in ((0.002, SOLID), (0.3, 0)):
        _, frame = drawn(1, width=1e-6, solids=ball, wide=wide)
        ids, mask = frame.aovs["strand_id"], frame.aovs["mask"]
        assert set(np.unique(ids)) <= {NOTHING, SOLID, 0}
        assert ids[24, 29] == 0  # where the strand is, however little of the pixel it covers
        assert ids[24, 40] == SOLID
        assert 1 / 64 < mask[24].max() < 0.1 if wide < 0.01 else mask[24].max() == pytest.approx(1)
        assert (mask[ids == NOTHING] < 1 / 64).all()
        assert holds in ids[24]
    _, thick = drawn(1, width=1e-6, wide=0.3)
    assert (thick.aovs["mask"] > 0.99).sum() > 100
