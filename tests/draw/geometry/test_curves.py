"""Smooth polylines against Bézier curves in float64: where they pass, how far off they are, what is left out."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from reference import curves as exact
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.geometry.curves import Polylines, flatten
from strandcli.draw.geometry.extent import widths_of
from strandcli.draw.view.camera import View, camera_view
from strandcli.draw.zbuffer.raster import to_screen
from strandcli.groom.blocks import lanes, pack
from strandcli.scene.model import Camera, Curves, Material
from tests.draw.view.test_camera import exact as project

BOX = np.array([[-2.0, -2, -2], [2, 2, 2]])
CAMERA = Camera(position=(0.0, 0.0, 4.0), fov=40.0)


class Strands:
    """Random walks of equal segments, bent by about ``bend`` a joint."""

    def __init__(self, count: int, n: int, seed: int = 0, bend: float = 0.6, scale: float = 1.0) -> None:
        rng = np.random.default_rng(seed)
        d = rng.normal(size=(count, 3))
        self.direction = d = d / np.linalg.norm(d, axis=1, keepdims=True)
        self.length = np.full(count, np.float32(scale / (n - 1)), np.float64)
        rows = [rng.uniform(-1, 1, (count, 3)) * scale]
        for _ in range(n - 1):
            rows.append(rows[-1] + d * self.length[:, None])
            d = d + rng.normal(size=(count, 3)) * bend
            d = d / np.linalg.norm(d, axis=1, keepdims=True)
        self.p = np.stack(rows, 1).astype(np.float32).astype(np.float64)
        self.count, self.n = count, n

    def flat(self, curves: Curves, view: View | None = None, keep_off_screen: bool = True) -> Polylines:
        before = self.p[:, :1] - self.direction[:, None] * self.length[:, None, None]
        packed = pack(np.concatenate([before, self.p], 1))
        view = view or camera_view(CAMERA, 0.0, 400, 300, BOX)
        return flatten(packed, lanes(self.length[:, None]), self.count, curves, view, keep_off_screen, Scratch())

    def points(self, pieces: int, printed: bool = False) -> np.ndarray:
        return exact.points(self.p, self.direction, self.length, pieces, printed)


def each(lines: Polylines) -> list[np.ndarray]:
    return [lines.world[a:b].astype(np.float64) for a, b in zip(lines.first[:-1], lines.first[1:], strict=True)]


def particles_of(line: np.ndarray, p: np.ndarray) -> list[int]:
    """Which vertices of a line are the particles (n, 3)."""
    at = [0]
    for particle in p[1:]:
        at.append(at[-1] + 1 + int(np.abs(line[at[-1] + 1 :] - particle).sum(1).argmin()))
    return at


@pytest.mark.parametrize("tangents", ["difference", "printed"])
@pytest.mark.parametrize("level", [0, 3])
@pytest.mark.parametrize("n", [2, 7])
def test_fixed_levels_are_the_curves_points(level: int, tangents: str, n: int) -> None:
    strands = Strands(70, n, bend=0.6, scale=0.5 * n)  # printed tangents want segments that are not short
    lines = strands.flat(Curves(mode="fixed", level=level, tangents=tangents))
    dense = strands.points(2**level, tangents == "printed")
    whole = np.concatenate([dense[:, :, :-1].reshape(70, -1, 3), dense[:, -1, -1:]], 1)
    np.testing.assert_allclose(lines.world.reshape(whole.shape), whole, atol=2e-6)
    assert lines.segments == 70 * (n - 1) * 2**level
    # every particle is a vertex, to the bit
    np.testing.assert_array_equal(lines.world.reshape(whole.shape)[:, :: 2**level], strands.p)


@pytest.mark.parametrize("tolerance", [1.0, 0.05])
@pytest.mark.parametrize("tangents", ["difference", "printed"])
@pytest.mark.parametrize(
    "camera",
    [
        CAMERA,
        Camera(position=(0.0, 0.0, 3.0), fov=110.0),
        Camera(kind="orthographic", position=(0.0, 0.0, 5.0), height=2.0),
    ],
    ids=["usual", "wide and near", "orthographic"],
)
def test_adaptive_curves_are_within_their_bound_on_the_screen(camera: Camera, tangents: str, tolerance: float) -> None:
    strands = Strands(60, 5, seed=3, scale=1.0 if tangents == "difference" else 1.6)
    view = camera_view(camera, 0.0, 400, 300, BOX)
    lines = strands.flat(Curves(mode="adaptive", level=8, tolerance=tolerance, tangents=tangents), view)
    dense = strands.points(256, tangents == "printed")
    worst = 0.0
    for s, line in enumerate(each(lines)):
        at = particles_of(line, strands.p[s])
        for i in range(strands.n - 1):
            shown, z = project(view, dense[s, i])
            piece, depth = project(view, line[at[i] : at[i + 1] + 1])
            inside = (shown > 0).all(1) & (shown < [400, 300]).all(1)
            if min(z.min(), depth.min()) > view.near and inside.any():
                worst = max(worst, exact.off_the_line(shown[inside], piece).max())
    assert worst <= lines.error <= tolerance * (1 + 1e-6)
    assert worst > 0.4 * tolerance  # and no more pieces than are of use
    capped = strands.flat(Curves(mode="adaptive", level=1, tolerance=tolerance / 10, tangents=tangents), view)
    assert capped.error > tolerance / 10  # what the level does not allow is told


def test_vertices_stand_along_their_strand_whatever_the_view() -> None:
    """Evenly within each segment between particles, however many pieces it has; so taper and colour stay where they
    are when the camera moves."""
    strands = Strands(60, 5, seed=3)
    for far in (2.0, 8.0):
        view = camera_view(Camera(position=(0.0, 0.0, far)), 0.0, 400, 300, BOX)
        lines = strands.flat(Curves(mode="adaptive", level=6), view)
        assert len(set(np.diff(lines.first))) > 3
        for s, line in enumerate(each(lines)):
            at = particles_of(line, strands.p[s])
            found = lines.along[lines.first[s] : lines.first[s + 1]]
            right = np.interp(np.arange(len(line)), at, np.linspace(0, 1, strands.n))
            np.testing.assert_allclose(found, right, atol=2e-7)


def test_strands_off_the_screen_are_left_out_unless_a_shadow_map_wants_them() -> None:
    strands = Strands(300, 5, seed=5, scale=0.5)
    strands.p[100:200] += [30, 0, 0]  # to the right
    strands.p[200:] += [0, 0, 10]  # behind
    curves = Curves(mode="adaptive", level=4)
    seen = np.diff(strands.flat(curves, keep_off_screen=False).first)
    assert (seen[100:] == 0).all()
    assert (seen[:100] > 0).sum() > 90
    kept = np.diff(strands.flat(curves, keep_off_screen=True).first)
    assert (kept[100:] == 5).all()  # coarsely: one piece a segment
    np.testing.assert_array_equal(kept[:100][seen[:100] > 0], seen[:100][seen[:100] > 0])
    away = camera_view(Camera(position=(0.0, 500.0, 0.0), target=(0.0, 900.0, 1.0)), 0.0, 64, 48, BOX)
    off_screen = strands.flat(curves, away, keep_off_screen=False)
    assert off_screen.segments == 0
    assert len(off_screen.world) == 0


def test_a_strand_that_is_seen_in_part_is_kept_whole() -> None:
    """And no strand that shows a single point of its curve is lost."""
    strands = Strands(2000, 5, seed=6, scale=2.0)
    for camera in (CAMERA, Camera(position=(0.3, 0.1, 0.2), near=0.05), Camera(kind="orthographic", height=0.4)):
        view = camera_view(camera, 0.0, 200, 50, BOX)
        lines = strands.flat(Curves(mode="adaptive", level=3), view, keep_off_screen=False)
        vertices = np.diff(lines.first)
        dense = strands.points(32).reshape(2000, -1, 3)
        shown, z = project(view, dense.reshape(-1, 3))
        inside = ((shown > 0) & (shown < [200, 50])).all(1) & (z > view.near)
        visible = inside.reshape(2000, -1).any(1)
        assert 20 < visible.sum() < 1900
        assert (vertices[visible] >= 5).all()
        assert (vertices == 0).sum() > 0.3 * (~visible).sum()  # most of the others are left out
        for s in np.flatnonzero(vertices)[:50]:
            line = lines.world[lines.first[s] : lines.first[s + 1]]
            for particle in strands.p[s]:
                assert np.abs(line - particle).sum(1).min() == 0


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_a_crop_window_aside_keeps_as_few_strands_as_one_in_the_middle(kind: str) -> None:
    """What it shows, and hardly more: strands on the other side of the axis are left out."""
    strands = Strands(4000, 3, seed=7, scale=0.1)
    strands.p[:, :, :2] *= 12  # a wide sheet of short strands
    strands.p[:, 1:] = strands.p[:, :1] + (strands.p[:, 1:] - strands.p[:, :1]) / 12
    view = camera_view(Camera(kind=kind, position=(0.0, 0.0, 4.0), fov=40.0, height=2.5), 0.0, 400, 300, BOX)
    middle = np.array([project(view, points)[0].mean(0) for points in strands.p])
    for corner in ([0, 0], [300, 0], [0, 230], [300, 230], [150, 115]):
        window = view.cropped(*corner, 100, 70)
        kept = np.diff(strands.flat(Curves(mode="adaptive", level=1), window, keep_off_screen=False).first) > 0
        inside = ((middle > corner) & (middle < np.add(corner, [100, 70]))).all(1)
        near = ((middle > np.subtract(corner, 25)) & (middle < np.add(corner, [125, 95]))).all(1)
        assert inside.sum() > 50
        assert kept[inside].all()
        assert not kept[~near].any()


def test_strands_that_shadow_a_crop_window_are_those_of_the_whole_picture() -> None:
    """Also where they are off the window, for which fewer pieces would do: maps, and so the light, would differ."""
    strands = Strands(300, 5, seed=3, scale=0.6)
    view = camera_view(Camera(position=(0.0, 0.0, 4.0), fov=40.0), 0.0, 400, 300, BOX)
    curves = Curves(mode="adaptive", level=4, tolerance=0.05)
    whole = strands.flat(curves, view, keep_off_screen=True)
    for window in (view.cropped(30, 200, 80, 50), view.cropped(10, 20, 300, 200).shifted(3, 2).cropped(99, 9, 40, 30)):
        part = strands.flat(curves, window, keep_off_screen=True)
        assert np.array_equal(part.first, whole.first)
        assert np.array_equal(part.world, whole.world)


CAMERAS = {
    "usual": Camera(position=(0.0, 0.0, 4.0), fov=40.0),
    "wide and near": Camera(position=(0.0, 0.0, 2.5), fov=110.0),
    "orthographic": Camera(kind="orthographic", position=(0.0, 0.0, 5.0), height=2.5),
}
ALL = Curves(mode="off")


def view_of(camera: Camera) -> View:
    return camera_view(camera, 0.0, 400, 300, BOX)


def wavy(count: int, n: int, jagged: float = 0.0) -> NDArray[np.float64]:
    """(count, n, 3) smooth waves, and steps aside by chance."""
    rng = np.random.default_rng(count + n)
    t = np.linspace(0, 1, n)[None, :, None]
    found = rng.uniform(-0.5, 0.5, (count, 1, 3)) + t * rng.normal(size=(count, 1, 3)) * 0.5
    for waves in (2, 5):
        found = found + 0.2 / waves * np.sin(waves * (t * 6 + rng.uniform(0, 6, (count, 1, 3))))
    return (found + jagged * rng.normal(size=found.shape)).astype(np.float32).astype(np.float64)


def flat(p: NDArray[np.float64], curves: Curves, view: View, fade: NDArray[np.float32] | None = None) -> Polylines:
    packed = pack(np.concatenate([2 * p[:, :1] - p[:, 1:2], p], 1))
    return flatten(packed, None, len(p), curves, view, True, Scratch(), fade)


@pytest.mark.parametrize("tolerance", [1.0, 0.1])
@pytest.mark.parametrize("jagged", [0.0, 0.002])
@pytest.mark.parametrize("name", CAMERAS)
def test_every_point_is_within_the_tolerance_on_the_screen(name: str, jagged: float, tolerance: float) -> None:
    p, view = wavy(150, 90, jagged), view_of(CAMERAS[name])
    lines = flat(p, Curves(mode="thinned", tolerance=tolerance), view)
    assert 0.5 * tolerance < lines.error <= tolerance
    worst = 0.0
    for points, a, b in zip(p, lines.first[:-1], lines.first[1:], strict=True):
        kept = lines.world[a:b].astype(np.float64)
        assert (kept[0] == points[0]).all()
        assert (kept[-1] == points[-1]).all()
        whole, few = (project(view, some)[0] for some in (points, kept))
        worst = max(worst, float(exact.off_the_line(whole, few).max()))
    assert worst < lines.error * 1.001 + 1e-3
    assert worst > 0.3 * tolerance
    assert lines.segments < (0.6 if tolerance == 1 else 0.98) * 150 * 89


def test_vertices_know_where_on_the_strand_they_stand() -> None:
    p, view = wavy(140, 70), view_of(CAMERAS["usual"])
    lines = flat(p, Curves(mode="thinned", tolerance=0.3), view)
    rows = np.rint(lines.along * 69).astype(int)
    strand = np.repeat(np.arange(140), np.diff(lines.first))
    np.testing.assert_array_equal(lines.along, rows.astype(np.float32) * np.float32(1 / 69))
    np.testing.assert_array_equal(lines.world, p[strand, rows])
    before, after = p[strand, np.maximum(rows - 1, 0)], p[strand, np.minimum(rows + 1, 69)]
    np.testing.assert_allclose(lines.tangents, after - before, atol=1e-6)


def test_widths_are_those_of_the_same_points_of_the_whole_strand() -> None:
    p, view = wavy(130, 80), view_of(CAMERAS["orthographic"])
    material = Material(width=0.01, taper=0.9)
    few, every = flat(p, Curves(mode="thinned", tolerance=0.2), view), flat(p, ALL, view)
    wide = [
        widths_of(lines, to_screen(lines, view, Scratch()), view, material, 0.0, True, Scratch())
        for lines in (few, every)
    ]
    rows = np.rint(few.along * 79).astype(int) + 80 * np.repeat(np.arange(130), np.diff(few.first))
    np.testing.assert_allclose(wide[0], wide[1][rows], rtol=1e-5)


def test_straight_strands_have_two_vertices_and_turns_back_are_kept() -> None:
    t = np.linspace(0, 1, 65)
    straight = np.stack([t, 0.5 * t, 0 * t], 1)
    back = np.stack([np.where(t < 0.75, t, 1.5 - t), 0 * t, 0 * t], 1)
    lines = flat(
        np.stack([straight, back]).astype(np.float32).astype(np.float64),
        Curves(mode="thinned"),
        view_of(CAMERAS["usual"]),
    )
    assert np.diff(lines.first).tolist() == [2, 3]
    assert lines.world[3, 0] == 0.75


def test_faded_strands_have_no_vertices_and_nothing_goes_at_a_tiny_tolerance() -> None:
    p, view = wavy(20, 66, 0.01), view_of(CAMERAS["usual"])
    fade = np.ones(20, np.float32)
    fade[3] = 0
    sizes = np.diff(flat(p, Curves(mode="thinned", tolerance=1e-6), view, fade).first)
    assert sizes[3] == 0
    assert (np.delete(sizes, 3) == 66).all()
