"""Masks of a sample's points: areas, strands that hide parts of each other, and pictures with exact shadows."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

import strandcli
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.coverage import coverage
from strandcli.draw.coverage.coverage import Coverage
from strandcli.draw.coverage.kernels.masks import DIRECTIONS, DISTANCES, REACH
from strandcli.draw.coverage.masks import half_planes, points
from strandcli.draw.geometry.curves import Polylines
from strandcli.study.axes import Request
from strandcli.study.pictures.settings import changed
from strandcli.study.pictures.subject import Subject

SIZE = 12
RNG = np.random.default_rng(8)


def test_each_strip_along_either_axis_has_one_point() -> None:
    for axis in points().T:
        np.testing.assert_array_equal(np.sort(((axis + 0.5) * 64).astype(int)), np.arange(64))


def test_as_many_points_lie_behind_a_line_as_there_is_area() -> None:
    """Against 256×256 points."""
    x, y = np.meshgrid(*2 * [(np.arange(256) + 0.5) / 256 - 0.5])
    table = half_planes().reshape(DIRECTIONS + 1, DISTANCES + 1)
    off = []
    for way in range(0, DIRECTIONS + 1, 7):
        w = 2 * way / DIRECTIONS
        normal = np.array([1 - w, min(w, 2 - w)])
        normal /= np.hypot(*normal)
        across = normal[0] * x + normal[1] * y
        for k, distance in enumerate(np.linspace(-REACH, REACH, DISTANCES + 1)):
            off.append(int(table[way, k]).bit_count() / 64 - (across < distance).mean())
    assert np.abs(off).max() < 0.05
    assert np.std(off) < 0.015  # of random points it would be .05
    assert abs(np.mean(off)) < 0.002


def layers(strands: np.ndarray, width: float, factor: int, exact: bool) -> np.ndarray:
    """(12, 12, 3) of strands (n, 2, 3) on the screen, each of a colour of its own, at factor² samples a pixel."""
    size = SIZE * factor
    screen = (strands * [factor, factor, 1]).reshape(-1, 3).astype(np.float32)
    lines = Polylines(np.arange(len(strands) + 1) * 2, screen)
    colours = np.repeat(np.random.default_rng(1).random((len(strands), 3)), 2, 0).astype(np.float32)
    image = np.zeros((size, size, 3), np.float32)
    widths = np.full(len(screen), width * factor, np.float32)
    for layer in Coverage((size, size), 1.0).layers(lines, screen, widths, None, 1, Scratch(), exact):
        layer.blend(colours, image)
    return image.reshape(SIZE, factor, SIZE, factor, 3).mean((1, 3))


def heap(rng: np.random.Generator, count: int) -> np.ndarray:
    """(count, 2, 3) straight strands at depths of their own."""
    ends = rng.uniform(-2, SIZE + 2, (count, 2, 2))
    return np.concatenate([ends, np.broadcast_to(rng.uniform(0.2, 0.9, (count, 1, 1)), (count, 2, 1))], 2)


@pytest.mark.parametrize(("width", "share"), [(0.2, 0.55), (0.4, 0.4), (0.7, 0.4), (1.3, 0.4), (3.0, 0.6)])
def test_what_is_in_front_hides_just_its_part_of_a_sample(width: float, share: float) -> None:
    """Against 16×16 samples. Without masks strands cover a sample independently; the wider they are the fewer share
    one, and an error of counting points is left."""
    strands = heap(np.random.default_rng(3), 60)
    right = layers(strands, width, 16, False)
    by_points, independent = layers(strands, width, 1, True), layers(strands, width, 1, False)
    error, plain = (np.sqrt(((found - right) ** 2).mean()) for found in (by_points, independent))
    assert error < share * plain
    assert abs(by_points.mean() / right.mean() - 1) < 0.005


def test_a_strand_alone_covers_as_much_as_without_masks() -> None:
    for strand in heap(RNG, 12):
        np.testing.assert_allclose(layers(strand[None], 1.2, 1, True), layers(strand[None], 1.2, 1, False), atol=1e-6)


@given(st.integers(0, 10_000), st.sampled_from([0.2, 0.6, 1.0, 2.5, 9.0]))
def test_shares_are_those_of_one_pixel(seed: int, width: float) -> None:
    strands = heap(np.random.default_rng(seed), 25).astype(np.float32)
    screen = strands.reshape(-1, 3)
    widths = np.full(len(screen), width, np.float32)
    lines = Polylines(np.arange(len(strands) + 1) * 2, screen)
    (layer,) = Coverage((SIZE, SIZE), 1.0).layers(lines, screen, widths, None, 1, Scratch(), True)
    at = int(layer.fragments.begin[0])
    for n in layer.fragments.counts[: 32 * SIZE]:
        shares = layer.fragments.weight[at : at + int(n)]
        assert (shares > 0).all()
        assert shares.sum() < 1 + 1e-6
        at += int(n)


SCENE: dict[str, Any] = {
    "emitter": {"shape": {"kind": "disc", "radius": 0.5}, "strands": 150, "particles": 6, "length": 0.9, "jitter": 40},
    "rules": [],
    "camera": {"position": [0, 1.1, 2], "target": [0, 0.3, 0], "fov": 40},
    "image": {"size": [40, 30], "background": [0, 0, 0], "resolver": "sorted"},
    "ambient": [0, 0, 0],
    "lights": [{"kind": "directional", "direction": [-0.3, -0.5, -0.8], "intensity": 3, "shadow": {"model": "traced"}}],
    "material": {"model": "chiang", "pigment": "brown", "diffuse": 0, "width": 0.05, "taper": 0},
    "curves": {"mode": "off"},
}


def test_light_is_that_of_the_part_that_is_seen(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """A picture of few samples against one of many."""
    (tmp_path / "scene.yaml").write_text(yaml.safe_dump(SCENE))
    subject = Subject(Request(strandcli.load(str(tmp_path / "scene.yaml")), "scene", size=(40, 30), strands=150))
    subject.move()

    def draw(samples: int) -> np.ndarray:
        return np.asarray(subject.draw(changed(subject.scene, {"image.supersample": samples}), draws=1).image)

    right = draw(12)
    found = draw(2)
    monkeypatch.setattr(coverage, "MASKED", np.inf)
    plain = draw(2)
    error, independent = (np.sqrt(((image - right) ** 2).mean()) / right.mean() for image in (found, plain))
    assert error < 0.65 * independent
    assert abs(found.mean() / right.mean() - 1) < 0.02
