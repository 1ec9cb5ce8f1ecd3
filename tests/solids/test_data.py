"""A shape of solid whose functions read arrays: a tube about a polyline, against the capsules that it is made of."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))

import tube

from shadow_kit import soft_visibility
from strandcli.draw.shadows.kernels import penumbra
from strandcli.draw.solids.kernels import rays
from strandcli.groom.emit import emit
from strandcli.scene import loads
from strandcli.scene.model import CapsuleSolid, Emitter
from strandcli.scene.model.solids import SHAPES
from strandcli.simulate import advice
from strandcli.simulate.rod.solver import RodSolver
from strandcli.simulate.rules import registry
from strandcli.simulate.thesis.solver import ThesisSolver
from strandcli.solids import Solids, pack_all, register

STILL = Emitter()
FAR, SKIN = np.float32(1e3), np.float32(1e-3)
STRANDS = """
solver: {solver}
time: {{preroll: 0, fps: 30, frames: 8}}
image: {{size: 8x8}}
emitter: {{strands: 64, length: 1.0, particles: 12, shape: {{kind: disc, radius: 0.5}}, rotation: [180, 0, 0]}}
rules: [{rules}]
solids: [{solids}]
"""
TUBES = "{kind: tube, position: [0.1, -0.6, 0.1], radius: 0.15}, {kind: tube, position: [0, -0.5, 0.4], width: 0.7}"


@pytest.fixture(autouse=True)
def registered() -> Iterator[None]:
    register(tube)
    yield
    del SHAPES._drivers["tube"]


def tubes() -> list[tube.Settings]:
    return [
        tube.Settings(radius=0.15, position=(0.1, -0.6, 0.1)),
        tube.Settings(radius=0.1, width=0.7, position=(0.0, -0.5, 0.4)),
    ]


def packed() -> tuple[Solids, Solids]:
    """Two tubes, and the eight capsules of which they are made."""
    return pack_all(tubes(), STILL, 0.0), pack_all(capsules(), STILL, 0.0)


def capsules() -> list[CapsuleSolid]:
    """Each turned about z so that its own y axis lies along an edge."""
    found = []
    for one in tubes():
        corners = tube.line(one) + one.position
        for a, b in itertools.pairwise(corners):
            angle = -np.degrees(np.arctan2(b[0] - a[0], b[1] - a[1]))
            middle, length = (a + b) / 2, float(np.linalg.norm(b - a))
            found.append(
                CapsuleSolid(
                    radius=one.radius, length=length, position=tuple(middle), rotation=(0.0, 0.0, float(angle))
                )
            )
    return found


def test_rays_and_shadows_are_those_of_the_capsules() -> None:
    one, many = packed()
    random = np.random.default_rng(1)
    hits = 0
    for _ in range(300):
        o = random.normal(size=3)
        o *= 3 / np.linalg.norm(o)
        d = random.uniform(-0.6, 0.6, 3) - o + (0, -0.5, 0.1)
        ray = (*o.astype(np.float32), *d.astype(np.float32))
        expected = min(float(rays.meet(many, m, *ray)) for m in range(8))
        found = min(float(rays.meet(one, m, *ray)) for m in range(2))
        hits += np.isfinite(expected) and np.isfinite(found)
        if np.isfinite(expected) and np.isfinite(found):
            assert found == pytest.approx(expected, abs=1e-3)
        point = random.uniform(-0.7, 0.7, 3).astype(np.float32) + np.array([0, -1.2, 0], np.float32)
        way = d / np.linalg.norm(d)
        lit = [rays.visibility(solids, *point, *way.astype(np.float32), FAR, SKIN) for solids in (one, many)]
        soft = [
            float(soft_visibility(
                solids, penumbra.LightRay(*point, *way.astype(np.float32), FAR), SKIN, np.float32(0.02), np.float32(0)
            )) for solids in (one, many)
        ]  # fmt: skip
        inside = advice.depth(point[None].astype(float), tubes()[0], STILL).max() > -5e-3
        inside |= advice.depth(point[None].astype(float), tubes()[1], STILL).max() > -5e-3
        assert inside or lit[0] == lit[1] or 0 < soft[1] < 1
        assert inside or soft[0] == pytest.approx(soft[1], abs=0.15)
    assert hits > 60


@pytest.mark.parametrize(("solver", "collision"), [
    ("thesis", "collision"), ("rod", "collision"), ("rod", "{collision: {segments: true}}"),
])  # fmt: skip
def test_strands_stay_outside(solver: str, collision: str) -> None:
    deepest = []
    first = "gravity, elasticity" if solver == "thesis" else "gravity"
    for rules in (first, f"{first}, {collision}"):
        text = STRANDS.format(solver=solver, rules=rules, solids=TUBES)
        scene = loads(text, rules=registry())
        groom = emit(scene.emitter, scene.seed)
        made: Any = RodSolver(scene, groom) if solver == "rod" else ThesisSolver(scene, groom)
        made.advance(8)
        points = made.particles()[:, 1:].reshape(-1, 3).astype(float)
        deepest.append(max(advice.depth(points, one, STILL).max() for one in scene.solids))
        errors = made.errors(8)
        if rules != first:
            assert errors["penetration_max"] == pytest.approx(max(deepest[-1], 0), abs=2e-6)
    free, kept = deepest
    assert free > 0.05
    assert kept < (1e-3 if solver == "thesis" else 1e-4)
