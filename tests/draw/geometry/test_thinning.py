"""Dense strands without the points that make no difference: how far off they are, and what is kept at each vertex."""

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
from strandcli.groom.blocks import pack
from strandcli.scene.model import Camera, Curves, Material
from tests.draw.view.test_camera import exact as project

BOX = np.array([[-2.0, -2, -2], [2, 2, 2]])
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
    np.testing.assert_allclose(lines.ways, after - before, atol=1e-6)


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
