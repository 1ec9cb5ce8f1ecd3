"""Exact shadows of a strand on itself: none at its joints, and those of a strand that comes back before itself."""

from __future__ import annotations

import numpy as np
import pytest

from strand_kit import frames_of, scene_of
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.coverage.kernels.column_light import LINES
from strandcli.draw.geometry.curves import Polylines
from strandcli.draw.geometry.extent import Thickness
from strandcli.draw.shadows.traced import grid_of
from strandcli.draw.view.camera import parallel_view
from strandcli.scene.model import DirectionalLight, Light, PointLight, Shadow

EXACT = Shadow(model="traced")
SUNS = [(0.0, 0.0, -1.0), (-0.079, -0.423, 0.903), (0.3, 1.0, 0.3), (0.0, -1.0, 0.05), (1.0, 0.1, 0.2)]
LIGHTS: list[Light] = [DirectionalLight(direction=way, shadow=EXACT) for way in SUNS]
LIGHTS += [PointLight(position=(0.5, 0.3, -2.0), shadow=EXACT), PointLight(position=(0.3, 0.1, -0.4), shadow=EXACT)]
NAMES = ["front", "back", "below", "along", "aside", "lamp", "near lamp"]


def lit(light: Light, world: np.ndarray, width: float, across: bool = True) -> tuple[np.ndarray, np.ndarray]:
    """The light at the vertices of one strand, and what is dark of the lines across it."""
    lines = Polylines(np.array([0, len(world)]), world.astype(np.float32))
    bounds = np.stack([world.min(0) - 1e-3, world.max(0) + 1e-3])
    grid = grid_of(light, lines, Thickness(width), 1.0, bounds, 1, Scratch())
    eye = parallel_view((0.0, 0.0, -1.0), 64, np.array([[-0.5] * 3, [0.5] * 3]))
    slots = np.arange(len(world), dtype=np.int32)
    shades = np.zeros((len(world), LINES), np.uint64)
    out = np.full(len(world), np.nan, np.float32)
    marks, screen = np.ones(len(world), np.uint8), np.zeros((len(world), 3), np.float32)
    if across:
        grid.visibility(lines, marks, screen, out, eye, slots, None, shades)
    else:
        grid.visibility(lines, marks, screen, out)
    return out, shades[:-1]


def straight(pieces: int) -> np.ndarray:
    return np.linspace([0, -0.2, 0], [0, 0.2, 0], pieces + 1)


def arc(pieces: int) -> np.ndarray:
    """A third of a circle in the plane of the picture, which no ray of `LIGHTS` meets twice but along the plane."""
    turn = np.linspace(-np.pi / 3, np.pi / 3, pieces + 1)
    return 0.2 * np.stack([np.cos(turn), np.sin(turn), 0 * turn], 1)


@pytest.mark.parametrize("across", [False, True], ids=["line", "across"])
@pytest.mark.parametrize("width", [0.0003, 0.003, 0.03])
@pytest.mark.parametrize("light", LIGHTS, ids=NAMES)
def test_a_straight_strand_is_evenly_lit_from_anywhere(light: Light, width: float, across: bool) -> None:
    for pieces in (1, 2, 3, 8, 40):
        out, dark = lit(light, straight(pieces), width, across)
        np.testing.assert_array_equal(out, 1.0)
        assert not dark.any()


@pytest.mark.parametrize("across", [False, True], ids=["line", "across"])
@pytest.mark.parametrize("width", [0.0003, 0.003, 0.03])
@pytest.mark.parametrize("light", [LIGHTS[0], LIGHTS[1], LIGHTS[5], LIGHTS[6]], ids=["front", "back", "lamp", "near"])
def test_a_bent_strand_is_evenly_lit_from_before_and_behind(light: Light, width: float, across: bool) -> None:
    for pieces in (2, 3, 8, 40):
        out, dark = lit(light, arc(pieces), width, across)
        np.testing.assert_array_equal(out, 1.0)
        assert not dark.any()


def test_a_fold_shades_itself_but_beside_its_joint() -> None:
    """Two long pieces, the second straight above the first: seen from above all of the first is dark but what lies
    within two and a half widths of the joint."""
    sun, width = DirectionalLight(direction=(0.0, -1.0, 0.0), shadow=EXACT), 0.004
    world = np.array([[-0.5, -0.1, 0], [0.5, -0.1, 0], [0.5, 0, 0], [-0.5, 0.0, 0]])
    out, _ = lit(sun, world, width, False)
    assert out[0] == pytest.approx(0, abs=1e-3)
    # the hat about the joint, over the first piece and the upright one, which is lit
    assert 0.5 < out[1] < 0.52
    np.testing.assert_array_equal(out[2:], 1.0)


@pytest.mark.parametrize("pieces", [12, 24, 200])
def test_a_ring_shades_its_lower_half(pieces: int) -> None:
    sun = DirectionalLight(direction=(0.0, -1.0, 0.0), shadow=EXACT)
    turn = np.linspace(0, 2 * np.pi, pieces + 1) + np.pi / 2
    out, _ = lit(sun, 0.3 * np.stack([np.cos(turn), np.sin(turn), 0 * turn], 1), 0.004, False)
    height = np.sin(turn)
    assert (out[height > 0.3] == 1).all()
    # of the first dark piece 2.5 widths beside its upper end, a quarter of it at most, count as the strand's own reach
    assert (out[height < -0.3] <= 1 / 32).all()


BEAD = """\
title: one straight strand lit from behind
emitter: {shape: {kind: disc, radius: 1.0e-9}, direction: [0, 1, 0], strands: 1, particles: %d, length: 0.4,
          position: [0, -0.2, 0]}
rules: {}
camera: {kind: orthographic, height: 0.48, position: [0, 0, 3], target: [0, 0, 0]}
image: {size: [64, 48], resolver: %s, background: [0, 0, 0], aovs: [linear]}
ambient: [0, 0, 0]
lights: [{kind: directional, direction: [-0.079, -0.423, 0.903], intensity: 3, shadow: {model: traced}}]
material: {model: chiang, eumelanin: 0.716, pheomelanin: 0, diffuse: 0, width: %g, taper: 0}
"""


@pytest.mark.parametrize("resolver", ["sorted", "zbuffer"])
@pytest.mark.parametrize("width", [0.03, 0.01, 0.002])
def test_a_picture_of_a_strand_alone_is_even_along_it(width: float, resolver: str) -> None:
    """Within .8 %, by which the profile of a wide strand wavers at its joints, whatever the light."""
    for particles in (3, 6):
        frame = frames_of(scene_of(BEAD % (particles, resolver, width)), 1)[0]
        rows = frame.aovs["linear"][6:42].sum((1, 2), dtype=np.float64)  # all but the strand's ends
        assert rows.mean() > 0.001
        np.testing.assert_allclose(rows, rows.mean(), rtol=8e-3)
