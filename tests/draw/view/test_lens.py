"""Lens and shutter: closed forms of blur, convergence, and what does not change when both are closed."""

from __future__ import annotations

import numpy as np
import pytest

from strand_kit import frames_of, scene_of
from strandcli.draw.view.lens import Exposure, exposures, focus_of, interpolate
from strandcli.groom.blocks import pack, unpack
from strandcli.scene.model import Camera, Emitter, PoseKey
from strandcli.scene.motion import apply, emitter_pose

BOX = np.array([[-1.0, -1, -1], [1, 1, 1]])
# one upright strand, 4 m away, white on black without any light but that from everywhere
LINE = """
emitter: {strands: 1, particles: 2, length: 9, direction: [0, 1, 0], position: [0, -4.5, 0],
  shape: {kind: disc, radius: 0.000001}, keys: %s}
rules: [emitter_motion]
time: {fps: 10}
camera: {position: [0.002, 0, 4], target: [0.002, 0, 0], fov: 30, %s}
image: {size: [80, 60], background: [0, 0, 0], aovs: [linear]}
ambient: [1, 1, 1]
curves: {mode: "off"}
material: {colour: [1, 1, 1], specular: 0, diffuse: 0}
lights: []
"""
FOCAL = 30 / np.tan(np.radians(15))


def line(camera: str, keys: str = "[]", frame: int = 1) -> np.ndarray:
    """(60, 80) linear light of the strand."""
    return np.asarray(frames_of(scene_of(LINE % (keys, camera)), frame)[0].aovs["linear"][..., 0], float)


def test_exposures_fill_lens_and_shutter_evenly_and_the_seed_alone_decides_them() -> None:
    camera = Camera(aperture=0.2, shutter=0.5, samples=256)
    shots = exposures(camera, 3, 2.0, 10.0)
    assert shots == exposures(camera, 3, 2.0, 10.0)
    assert shots != exposures(camera, 4, 2.0, 10.0)
    at = np.array([shot.at for shot in shots])
    assert at.min() >= 1.95
    assert at.max() <= 2.0
    assert np.abs(np.sort(at) - np.linspace(1.95, 2.0, 256)).max() < 0.05 / 255
    np.testing.assert_allclose([shot.share for shot in shots], 1 - (2.0 - at) * 10, atol=1e-12)
    lens = np.array([[shot.right, shot.up] for shot in shots])
    assert np.hypot(*lens.T).max() <= 0.1
    aside = np.array([[shot.x, shot.y] for shot in shots])
    assert np.abs(aside).max() <= 0.5
    assert (np.histogram2d(*aside.T, bins=4, range=[[-0.5, 0.5]] * 2)[0] >= 12).all()  # of 16 on the mean
    assert np.abs(lens.mean(0)).max() < 0.003
    # the mean square of a disc's points is half the square of its radius
    assert np.mean((lens**2).sum(1)) == pytest.approx(0.005, rel=0.02)
    assert exposures(Camera(samples=256), 3, 2.0, 10.0) == [Exposure(2.0, 1.0)]
    assert all(shot.at == 0 for shot in exposures(camera, 3, 0.0, 10.0))  # nothing moves before the first frame


def over_pixels(places: np.ndarray, light: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The share of light that each pixel about x has from lines one pixel wide at these places."""
    share = np.array([np.sum(light * np.clip(1 - np.abs(places - middle), 0, None)) for middle in x])
    return np.asarray(share / light.sum())


@pytest.mark.parametrize(("focus", "aperture"), [(2.0, 0.3), (3.0, 0.6), (20.0, 0.5)])
def test_a_strand_out_of_focus_is_as_wide_as_the_circle_of_confusion(focus: float, aperture: float) -> None:
    """A line seen through a disc: its light across is the disc's chords, (8 / π d²) √(d²/4 − x²) a pixel."""
    image = line(f"aperture: {aperture}, focus: {focus}, samples: 1024")
    camera = Camera(position=(0.0, 0.0, 4.0), aperture=aperture, focus=focus)
    circle = FOCAL * aperture * abs(1 / focus_of(camera, 0.0) - 1 / 4.0)  # diameter, pixels
    assert circle > 4
    row = image[30]
    assert row.sum() == pytest.approx(1, abs=1e-4)  # the light of a line one pixel wide
    x = np.arange(80) + 0.5 - (40 - 0.002 / 4 * FOCAL)
    assert (row[np.abs(x) > circle / 2 + 1.1] == 0).all()
    assert (row[np.abs(x) < circle / 2 - 0.6] > 0).all()
    fine = np.linspace(-circle / 2, circle / 2, 100_001)
    chords = np.sqrt(np.maximum(circle**2 / 4 - fine**2, 0))
    exact = over_pixels(fine, chords, x)
    # two thirds of what 1024 random points would be off by: places within a pixel are a further dimension
    assert np.abs(row - exact).max() < 0.015
    assert np.sum(row * x**2) == pytest.approx(circle**2 / 16 + 1 / 6, rel=0.06)  # the pixel's box, and the line's


def test_what_is_in_focus_stays_sharp_and_is_antialiased() -> None:
    """A line a pixel wide covers its pixels by exact shares; sorted, each exposure by itself does."""
    exact = over_pixels(np.array([40 - 0.002 / 4 * FOCAL]), np.ones(1), np.arange(80) + 0.5)
    assert exact.max() < 0.6
    for focus in ("", "focus: 4,"):  # by default the target's
        rows = line(f"aperture: 0.3, {focus} samples: 64")
        np.testing.assert_allclose(rows, np.broadcast_to(exact, rows.shape), atol=1 / 32)
    assert line("").max() == pytest.approx(1)
    text = LINE.replace("image: {", "image: {resolver: sorted, ") % ("[]", "aperture: 0.3, samples: 3")
    rows = frames_of(scene_of(text), 1)[0].aovs["linear"][..., 0]
    np.testing.assert_allclose(rows, np.broadcast_to(exact, rows.shape), atol=1e-3)


def test_with_lens_and_shutter_closed_there_is_one_exposure() -> None:
    one, many = (frames_of(scene_of(LINE % ("[]", f"samples: {n}")), 1)[0] for n in (1, 4096))
    np.testing.assert_array_equal(one.aovs["linear"], many.aovs["linear"])
    assert "exposures" not in many.report["counts"]


def test_a_moving_strand_is_spread_over_its_way() -> None:
    """The root goes 3 m/s to the right and the tip stays: at a height y between them an even streak, as long as the
    strand moves there in half of 0.1 s, that ends where the strand is at the frame's own time."""
    keys = "[{time: 0, position: [-1, -4.5, 0], ease: linear}, {time: 1, position: [2, -4.5, 0]}]"
    row = line("shutter: 0.5, samples: 512", keys, 11)[30]
    share = 0.5 + 0.5 * 4 / FOCAL / 9  # of the root, at the middle of that row of pixels
    streak = FOCAL * 3 * share * 0.05 / 4
    end = 3 * share - 1  # the tip is at −1
    x = np.arange(80) + 0.5 - (40 + (end - 0.002) / 4 * FOCAL)
    assert row.sum() == pytest.approx(1, abs=1e-4)
    covered = over_pixels(np.linspace(-streak, 0, 10_001), np.ones(10_001), x)
    assert np.abs(row - covered).max() < 0.01  # half of what 512 random points would be off by
    still = line("aperture: 1.0e-9, samples: 4", keys)
    np.testing.assert_allclose(line("shutter: 0.5, samples: 4", keys), still, atol=1e-6)


def test_between_frames_what_the_emitter_carries_is_exact() -> None:
    """And in the world a chord is off by at most an eighth of the acceleration times the square of the time."""
    emitter = Emitter(
        keys=(
            PoseKey(time=0.0, ease="linear"),
            PoseKey(time=1.0, position=(0.0, 2.0, 0.0), rotation=(0.0, 90.0, 30.0), ease="linear"),
        )
    )
    local = np.random.default_rng(1).normal(size=(150, 3, 3))

    def world(time: float) -> np.ndarray:
        pose = emitter_pose(emitter, time)
        return np.array([[apply(pose, tuple(point)) for point in strand] for strand in local])

    before, after = (pack(world(time)) for time in (0.2, 0.6))
    shot = Exposure(0.4, 0.5)
    found = unpack(interpolate(before, after, emitter, True, 0.2, 0.6, shot, np.empty_like(before)), 150)
    np.testing.assert_allclose(found, world(0.4), atol=2e-6)
    chord = unpack(interpolate(before, after, emitter, False, 0.2, 0.6, shot, np.empty_like(before)), 150)
    steps = np.array([world(time) for time in np.linspace(0.2, 0.6, 81)])
    acceleration = np.linalg.norm(np.diff(steps, 2, axis=0), axis=-1).max(0) / 0.005**2
    off = np.linalg.norm(chord - world(0.4), axis=-1)
    assert (off < acceleration * 0.4**2 / 8 + 1e-5).all()
    assert off.max() > 0.1
    ends = [interpolate(before, after, emitter, True, 0.2, 0.6, Exposure(t, s), np.empty_like(before)) for t, s in
            ((0.2, 0.0), (0.6, 1.0))]  # fmt: skip
    np.testing.assert_allclose(ends[0], before, atol=2e-6)
    np.testing.assert_allclose(ends[1], after, atol=2e-6)


def test_solids_and_camera_move_while_the_shutter_is_open() -> None:
    """A ball that crosses at 1 m/s, then a camera that does so past a ball at rest: the same streak, mirrored."""
    text = """
emitter: {strands: 1, particles: 2, length: 0.001, position: [0, 90, 0]}
rules: []
time: {fps: 10}
camera: {position: [0, 0, 4], target: [0, 0, 0], fov: 30, shutter: 1, samples: 64, keys: %s}
image: {size: [80, 60], background: [0, 0, 0], aovs: [linear]}
ambient: [1, 1, 1]
lights: []
solids: [{kind: sphere, radius: 0.2, colour: [1, 1, 1], keys: %s}]
"""
    ball = "[{time: 0, ease: linear}, {time: 1, position: [1, 0, 0]}]"
    eye = "[{time: 0, ease: linear}, {time: 1, position: [-1, 0, 4], target: [-1, 0, 0]}]"
    moved, passed = (
        frames_of(scene_of(text % keys), 4)[0].aovs["linear"][30, :, 0] for keys in (("[]", ball), (eye, "[]"))
    )
    np.testing.assert_allclose(moved, passed, atol=0.05)
    wide = 2 * 0.2 / 4 * FOCAL * 1.00125
    assert moved.sum() == pytest.approx(wide, abs=0.5)
    assert np.count_nonzero(moved) == pytest.approx(wide + 0.1 / 4 * FOCAL, abs=1.5)
