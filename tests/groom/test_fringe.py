"""A fringe: children at hairline and parting, as dense and as long as asked, and what is no part of it as it was."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from scene_kit import complaint
from strand_kit import scene_of
from strandcli.groom.children import Children
from strandcli.groom.emit import emit, rim, sides
from strandcli.scene.model import Fringe, SphereShape

RADIUS, CAP, RAGGED, PARTING = 0.1, 108.0, 12.0, -0.02
FRINGE = Fringe(share=0.3, within=0.006, length=0.25)
SCENE = f"""
seed: 5
emitter: {{strands: 500, particles: 9, length: 0.3, comb: [0.75, -0.25, -0.55], parting: {PARTING},
  shape: {{kind: sphere, radius: {RADIUS}, cap: {CAP}, ragged: {RAGGED}}}}}
children: {{count: 80}}
"""


def family(fringe: Fringe | None = FRINGE, count: int = 80, **emitter: Any) -> Children:
    """The children of a combed head."""
    scene = scene_of(SCENE)
    assert scene.children is not None
    scene = dataclasses.replace(
        scene,
        children=dataclasses.replace(scene.children, fringe=fringe, count=count),
        emitter=dataclasses.replace(scene.emitter, **emitter),
    )
    return Children(scene, emit(scene.emitter, scene.seed))


def polar(children: Children) -> tuple[np.ndarray, np.ndarray]:
    """How far each root is from the pole and from its meridian's rim, as arcs in metres."""
    roots = children.every.roots.astype(float)
    turn = np.arctan2(roots[:, 2], roots[:, 0]) / (2 * np.pi) % 1.0
    away = RADIUS * np.arccos(np.clip(roots[:, 1] / RADIUS, -1, 1))
    return away, RADIUS * np.radians(rim(children.scene.emitter.shape, turn, children.scene.seed)) - away


def across(children: Children) -> np.ndarray:
    """How far each root is from the plane of the parting, as an arc in metres; to the left less than 0."""
    x = children.every.roots[:, 0].astype(float) / RADIUS
    return np.asarray(RADIUS * (np.arcsin(np.clip(x, -1, 1)) - np.arcsin(PARTING / RADIUS)))


def test_what_is_no_part_of_it_stays() -> None:
    plain, children = family(None), family()
    moved = (plain.every.roots != children.every.roots).any(1)
    assert not moved[:500].any()  # guides
    assert moved[500:].mean() == pytest.approx(FRINGE.share, abs=0.01)
    np.testing.assert_array_equal(children.every.directions[~moved], plain.every.directions[~moved])
    np.testing.assert_array_equal(children.family.shares == 1, ~moved[children.family.ids])
    np.testing.assert_allclose(np.linalg.norm(children.every.roots, axis=1), RADIUS, rtol=1e-6)


def test_at_the_hairline_it_thins_out_inward() -> None:
    """Without a parting all of it is there, at distances of which `within` is the mean, and never beyond the rim."""
    children = family(parting=None)
    moved = (family(None, parting=None).every.roots != children.every.roots).any(1)
    inside = polar(children)[1][moved]
    assert inside.min() > -1e-6
    assert inside.mean() == pytest.approx(FRINGE.within, rel=0.03)
    assert (inside < FRINGE.within).mean() == pytest.approx(1 - np.exp(-1), abs=0.02)


def test_along_the_parting_it_grows_on_both_sides() -> None:
    """On a whole sphere all of it is there, from the crown on ahead."""
    whole = SphereShape(radius=RADIUS)
    children = family(shape=whole)
    moved = (family(None, shape=whole).every.roots != children.every.roots).any(1)
    away = across(children)[moved]
    assert np.abs(away).mean() == pytest.approx(FRINGE.within, rel=0.03)
    assert (away < 0).mean() == pytest.approx(0.5, abs=0.02)
    # where hair is parted: there strands to either side of it are combed apart
    assert (np.abs(sides(children.scene.emitter, children.every.roots[moved])) > 0.1).mean() > 0.99


def test_lengths_are_even_down_to_the_shortest() -> None:
    shares = family().family.shares
    own = shares[shares < 1]
    assert own.min() == pytest.approx(FRINGE.length, abs=0.01)
    assert own.mean() == pytest.approx((1 + FRINGE.length) / 2, abs=0.01)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("children: {fringe: {share: 2}}", "children.fringe.share: must be a number"),
        ("children: {fringe: {}}", "children.fringe: a fringe grows at a sphere's `cap`"),
        ("emitter: {shape: {kind: disc}}\nchildren: {fringe: {}}", "children.fringe: a fringe grows at a sphere's"),
        ("emitter: {tie: {}}\nchildren: {fringe: {}}", "children.fringe: strands that are tied"),
    ],
)
def test_refused(text: str, words: str) -> None:
    assert words in complaint(text)
