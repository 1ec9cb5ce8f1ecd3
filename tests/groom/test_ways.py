"""The ways of tied strands, point by point, beside a twin that is written out for one strand and knows no chart."""

from __future__ import annotations

import dataclasses
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from strandcli.groom.emit import emit
from strandcli.groom.tie import Chart, chart_of, paths
from strandcli.scene.model import Emitter, SphereShape, Tie
from strandcli.scene.model.emitter import TIED

RADIUS = 0.1
BALL, HEAD, CAP = (SphereShape(radius=RADIUS, cap=cap) for cap in (180, 110, 60))
LOW, THICK = {"radius": 0.016, "lift": 0.002}, {"radius": 0.006, "lift": 0.012}
"""Ties whose bundle begins to turn up by its radius, and by the tie's height."""
TIES = [
    (BALL, Tie(position=(0.05, -0.03, 0.08), **LOW)),
    (HEAD, Tie(position=(0.02, 0.09, -0.04), **THICK, direction=(0.3, 0.5, -1.0), spread=25.0)),
    (CAP, Tie(position=(0.0, 0.08, 0.06), **LOW)),
]


def emitter_of(shape: Any, tie: Tie, strands: int = 12) -> Emitter:
    return Emitter(strands=strands, length=0.3, shape=shape, tie=tie)


def turned(vector: np.ndarray, axis: np.ndarray, angle: float) -> np.ndarray:
    """By Rodrigues' formula."""
    along = (vector @ axis) * axis
    return np.asarray(along + np.cos(angle) * (vector - along) + np.sin(angle) * np.cross(axis, vector))


def at(chart: Chart, d: float, way: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The point of the surface at a distance d along a way, and the normal there: a turn of the ball."""
    normal = turned(chart.normal, np.cross(chart.normal, way), d / RADIUS)
    return RADIUS * normal, normal


def grows(chart: Chart, point: np.ndarray) -> bool:
    """Whether strands grow at a place of the surface."""
    return bool(np.arccos(np.clip(point[1] / RADIUS, -1, 1)) <= chart.cap)


def rim(chart: Chart, way: np.ndarray) -> float:
    """How far along a way strands grow, found by going there: at the most to the place opposite of the foot."""
    far = np.pi * RADIUS
    steps = np.linspace(0, far, 100)
    out = [d for d in steps if not grows(chart, at(chart, d, way)[0])]
    if not out:
        return float(far)
    low, high = out[0] - steps[1], out[0]
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if grows(chart, at(chart, middle, way)[0]) else (low, middle)
    return float(low)


def away(points: np.ndarray) -> np.ndarray:
    """How far up some solid has points lie: here and there more."""
    return np.asarray(0.003 + 0.02 * points[:, 0])


def way_of(emitter: Emitter, root: np.ndarray, end: np.ndarray, leaves: np.ndarray, bow: np.ndarray) -> np.ndarray:
    """(1 + TIED, 3) the way of one strand: fourteen places along the surface as high as the hair that crosses there,
    more by its bow and by what it lies over, then six of a curve by Bézier up into the bundle."""
    chart, tie = chart_of(emitter), emitter.tie
    assert tie is not None
    normal = chart.foot / RADIUS
    along = root - (root @ normal) * normal
    along = along / np.linalg.norm(along)
    whole = RADIUS * np.arccos(np.clip(root @ normal / RADIUS, -1, 1))

    def cap(d: float) -> float:
        return float(RADIUS**2 * (1 - np.cos(d / RADIUS)))

    most = cap(rim(chart, along))

    def on(d: float) -> np.ndarray:
        bare, up = at(chart, d, along)
        ring = RADIUS * np.sin(d / RADIUS)
        rooted_farther = max(cap(whole) - cap(d), 0.0) / most
        height = 0.5 * tie.radius**2 * rooted_farther / ring + float(away(bare[None])[0])
        bowed = np.sin(np.pi * min(d / whole, 1.0)) ** 2
        return np.asarray(bare + (height + bow[0] * bowed) * up + bow[1] * bowed * np.cross(normal, along))

    axis = normal if tie.direction is None else np.array(tie.direction) / np.linalg.norm(tie.direction)
    aside = np.linalg.norm(end - (chart.foot + tie.lift * axis))
    last = min(aside + 1.2 * max(tie.lift, tie.radius / 2), whole / 2)
    points = [on(whole + (last - whole) * k / 14) for k in range(14)]
    small = 1e-3 * whole
    start, begins = on(last), on(last) - on(last + small)
    reach = np.linalg.norm(end - start) / 3
    handles = [start, start + reach * begins / np.linalg.norm(begins), end - reach * leaves, end]
    up = at(chart, last, along)[1]
    for k in range(6):
        line = handles
        while len(line) > 1:  # by de Casteljau
            line = [one + k / 6 * (two - one) for one, two in pairwise(line)]
        points.append(line[0] + float(away(line[0][None])[0]) * up)
    back = on(whole + small) - points[0]
    before = points[0] + np.linalg.norm(points[1] - points[0]) * back / np.linalg.norm(back)
    return np.array([before, *points])


@pytest.mark.parametrize(("shape", "tie"), TIES)
def test_ways_are_those_of_the_twin(shape: Any, tie: Tie) -> None:
    emitter = emitter_of(shape, tie)
    groom = emit(emitter, 0)
    assert groom.grown is not None
    bows = 0.01 * np.random.default_rng(1).uniform(-1, 1, (groom.strands, 2))
    found = paths(emitter, groom, bows, lambda points, normals: away(points))
    assert found.shape == (groom.strands, 1 + TIED, 3)
    columns = groom.grown, groom.roots, groom.directions, bows
    expected = [way_of(emitter, *(column[s].astype(np.float64) for column in columns)) for s in range(groom.strands)]
    np.testing.assert_allclose(found, expected, atol=1e-7)


def test_a_strand_that_grows_at_the_tie_stays_there() -> None:
    emitter = emitter_of(BALL, Tie(position=(0.05, -0.03, 0.08), **LOW), 1)
    chart = chart_of(emitter)
    bound = chart.foot + 0.002 * chart.normal
    groom = dataclasses.replace(
        emit(emitter, 0), grown=chart.foot[None], roots=bound[None], directions=chart.normal[None]
    )
    (found,) = paths(emitter, groom, np.zeros((1, 2)), lambda points, normals: 0 * points[:, 0])
    np.testing.assert_allclose(found[1:14], np.broadcast_to(chart.foot, (13, 3)), atol=1e-8)
    # and turns up as others do, who come along the surface: no cubic's end is farther off than 4/27 of its slope
    assert np.linalg.norm(np.cross(found - chart.foot, chart.normal), axis=1).max() < 4 / 27 * 0.002
