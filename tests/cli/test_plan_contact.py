"""`plan` refuses of contact between strands what `render` would refuse."""

from __future__ import annotations

import numpy as np
import pytest

from strandcli.cli.main import main
from strandcli.groom.emit import emit
from strandcli.plan import Plan, crowding, make_plan
from strandcli.plan.crowding import pairs_of
from strandcli.scene import load
from strandcli.simulate.rules import registry

ROD = ("minimal", "--strands", "20", "--set", "solver=rod", "--set")


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (("rules=[gravity, {contact: {thickness: 99}}]",), "rule contact.thickness: 99 m is more than the groom"),
        (("rules=[gravity, {contact: {}}]", "--set", "rod.integrator=bdf2"), "bdf2 does not go with the rule contact"),
        (("rules=[gravity, {interaction: {cell: 1e-9}}]",), "cell: 1e-09 m is less than a strand's thickness"),
        (("rules=[gravity, {interaction: {cell: 0.001}}]",), "is less than a 64th of a segment"),
    ],
)
def test_contact_that_rods_refuse(settings: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plan", *ROD, *settings]) == 2
    assert words in capsys.readouterr().err


def test_contact_takes_memory_where_strands_are_many() -> None:
    """560 bytes a particle, and 50 a pair of boxes that meet."""
    for strands, more in ((200, 1e6), (20_000, 142e6)):
        plain, touching = (
            plan_of("minimal", f"emitter.strands={strands}", "solver=rod", f"rules=[gravity{rule}]").memory_bytes
            for rule in ("", ", {contact: {}}")
        )
        assert abs(touching - plain - more) < 20e6, strands


def test_pairs_are_those_of_all_segments_and_grow_with_the_square_of_strands() -> None:
    """The sample beside every pair of boxes, strands that fall for a step."""
    settings = ("emitter.strands=400", "solver=rod", "rules=[gravity, {contact: {thickness: 0.1}}]")
    scene = load("minimal", rules=registry(), overrides=settings)
    groom, n = emit(scene.emitter, scene.seed), scene.emitter.particles
    share = np.linspace(0, 1, n)[:, None]
    x = groom.roots[:, None] + groom.directions[:, None] * groom.lengths[:, None, None] * share
    moved = x - np.array([0, 9.81 / (scene.time.fps * scene.time.substeps) ** 2, 0])
    ends = np.stack([x[:, :-1], x[:, 1:], moved[:, :-1], moved[:, 1:]])
    low, high = (ends.min(0) - 0.075).reshape(-1, 3), (ends.max(0) + 0.075).reshape(-1, 3)
    strand = np.repeat(np.arange(400), n - 1)
    meet = (low[:, None] <= high[None]).all(2) & (high[:, None] >= low[None]).all(2) & (strand[:, None] != strand)
    pairs = meet.sum() / 2
    assert pairs > 5000
    assert pairs_of(scene, 400) == pytest.approx(pairs, rel=0.15)
    assert pairs_of(scene, 40 * crowding.STRANDS) == 1600 * pairs_of(scene, crowding.STRANDS)


def plan_of(preset: str, *overrides: str) -> Plan:
    return make_plan(load(preset, rules=registry(), overrides=overrides), [1])
