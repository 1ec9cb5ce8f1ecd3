"""Which of several wide strands is seen where they touch and run into each other, against rays at cylinders."""

from __future__ import annotations

import numpy as np
import pytest

from strandcli.draw.common.kernels.keys import EMPTY
from strandcli.draw.common.kernels.view_columns import FLAT, DepthSlope
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.coverage.coverage import Coverage
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.view.camera import View, axes
from strandcli.draw.zbuffer import raster

WIDTH, HEIGHT = 160, 120
RADIUS = 0.06


def seen_from(perspective: bool) -> View:
    eye = np.array([0.3, 0.2, 4.0])
    return View(eye, *axes(-eye, (0.0, 1.0, 0.0)), perspective, 240.0 if perspective else 60.0, 0.1, 9.0, WIDTH, HEIGHT)


def heap(strands: int, pieces: int) -> np.ndarray:
    """(strands, pieces + 1, 3) straight strands, a bundle that is slanted toward the eye, many within others."""
    rng = np.random.default_rng(4)
    way = rng.normal([1, 0.5, 1], 0.2, (strands, 1, 3))
    way /= np.linalg.norm(way, axis=2, keepdims=True)
    middle = rng.normal(0, 0.15, (strands, 1, 3))
    return np.asarray(middle + way * np.linspace(-2, 2, pieces + 1)[:, None])


def cast(view: View, strands: np.ndarray, right: float = 0.0, down: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """(height, width) of the foremost strand at so many pixels from each pixel's middle, and by how many radii it is in
    front of the next; rays at cylinders."""
    y, x = np.mgrid[:HEIGHT, :WIDTH] + 0.5
    cx, cy = view.middle
    aside = (x + right - cx)[..., None] * view.right - (y + down - cy)[..., None] * view.up
    origin = view.eye + (0 if view.perspective else aside / view.focal)
    way = view.forward + (aside / view.focal if view.perspective else 0 * aside)
    way /= np.linalg.norm(way, axis=-1, keepdims=True)
    depth = np.empty((len(strands), HEIGHT, WIDTH))
    for i, line in enumerate(strands):
        long = np.linalg.norm(line[-1] - line[0])
        t = (line[-1] - line[0]) / long
        begin = origin - line[0]
        p, q = way - (way @ t)[..., None] * t, begin - (begin @ t)[..., None] * t
        a, b, c = (p * p).sum(-1), (p * q).sum(-1), (q * q).sum(-1) - RADIUS**2
        square = b * b - a * c
        at = (-b - np.sqrt(np.maximum(square, 0))) / a
        along = begin @ t + at * (way @ t)
        depth[i] = np.where((square > 0) & (along > 0) & (along < long), at, 99)
    first, second = np.sort(depth, 0)[:2]
    return depth.argmin(0), (second - first) / RADIUS


def contest(view: View, strands: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(height, width) of the foremost strand, and where two run into each other, at most a radius apart, but which is
    in front is beyond doubt: everywhere in the pixel, and by a twentieth of a radius."""
    first, apart = cast(view, strands)
    sure = (apart > 0.05) & (apart < 1)
    for right, down in ((-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)):
        sure &= cast(view, strands, right, down)[0] == first
    return first, sure


def draw(view: View, strands: np.ndarray, resolver: str, slope: DepthSlope) -> np.ndarray:
    """(height, width) of the foremost strand, −1 where there is none."""
    count, points, _ = strands.shape
    lines = Polylines(np.arange(count + 1) * points, strands.reshape(-1, 3).astype(np.float32))
    screen = raster.to_screen(lines, view, Scratch())
    widths = np.full(len(screen), 2 * RADIUS * view.focal, np.float32)
    if view.perspective:
        widths *= screen[:, 2]
    if resolver == "zbuffer":
        keys = np.full(WIDTH * HEIGHT, EMPTY)
        raster.draw(lines, screen, widths, 0, (WIDTH, HEIGHT), 1, Scratch(), keys, slope)
        number = (keys & np.uint64(0xFFFFFFFF)).astype(np.int64)
        return np.where(keys == EMPTY, -1, number // points).reshape(HEIGHT, WIDTH)
    colours = np.repeat(np.arange(count, dtype=np.float32), points)[:, None] * np.ones(3, np.float32)
    image = np.full((HEIGHT, WIDTH, 3), -1, np.float32)
    coverage = Coverage((WIDTH, HEIGHT), 1.0)
    for layer in coverage.layers(lines, screen, widths, None, 1, Scratch(), slope):
        layer.blend(colours, image)
    return image[..., 0]


@pytest.mark.parametrize("perspective", [True, False], ids=["perspective", "orthographic"])
@pytest.mark.parametrize("resolver", ["sorted", "zbuffer"])
@pytest.mark.parametrize("pieces", [1, 12])
def test_strands_that_touch_hide_each_other_as_cylinders_do(resolver: str, perspective: bool, pieces: int) -> None:
    view, strands = seen_from(perspective), heap(30, pieces)
    right, sure = contest(view, strands)
    assert sure.sum() > 500
    wrong, flat = (
        (abs(draw(view, strands, resolver, slope) - right) > 0.01)[sure].mean() for slope in (view.depth_slope, FLAT)
    )
    assert wrong < 0.02
    assert flat > 6 * wrong  # bands without a round side: a tenth of the pixels or more


@pytest.mark.parametrize("resolver", ["sorted", "zbuffer"])
def test_far_aside_of_the_views_axis_the_edges_of_a_strand_are_not_equally_far(resolver: str) -> None:
    """Nearly parallel strands that lie in each other, in the corner of a wide lens's picture."""
    eye = np.array([0.3, 0.2, 4.0])
    view = View(eye, *axes(-eye, (0.0, 1.0, 0.0)), True, 240.0, 0.1, 9.0, WIDTH, HEIGHT, centre=(-160.0, 300.0))
    rng = np.random.default_rng(2)
    way = rng.normal([1, 0.5, 1], 0.06, (40, 1, 3))
    way /= np.linalg.norm(way, axis=2, keepdims=True)
    middle = eye + 4 * (view.forward + view.right + view.up) + rng.normal(0, 0.12, (40, 1, 3))
    strands = middle + way * np.linspace(-2, 2, 13)[:, None]
    right, sure = contest(view, strands)
    assert sure.sum() > 500
    # as if the view's axis went through the middle of the picture
    middle_of_picture = view.depth_slope._replace(axis_x=np.float32(WIDTH / 2), axis_y=np.float32(HEIGHT / 2))
    wrong, even = (
        (abs(draw(view, strands, resolver, slope) - right) > 0.01)[sure].mean()
        for slope in (view.depth_slope, middle_of_picture)
    )
    assert wrong < 0.02
    assert even > 3 * wrong
