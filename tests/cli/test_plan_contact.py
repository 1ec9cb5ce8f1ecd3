"""`plan` refuses of contact between strands what `render` would refuse."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from strandcli.cli.main import main
from strandcli.groom.emit import emit
from strandcli.plan import Plan, crowding, make_plan
from strandcli.plan.crowding import crowding_of
from strandcli.scene import load
from strandcli.simulate.contact.kernels import contact_pairs
from strandcli.simulate.contact.nearby import Nearby
from strandcli.simulate.rod.solver import RodSolver
from strandcli.simulate.rules import registry

ROD = ("minimal", "--strands", "20", "--set", "solver=rod", "--set")


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (("rules=[gravity, {contact: {thickness: 99}}]",), "rule contact.thickness: 99 m is more than the groom"),
        (("rules=[gravity, {interaction: {cell: 1e-9}}]",), "cell: 1e-09 m is less than a strand's thickness"),
        (("rules=[gravity, {interaction: {cell: 1e9}}]",), "cell: 1e+09 m is larger than the groom, which is at most"),
        (("rules=[gravity, {interaction: {cell: 0.001}}]",), "is less than a 64th of a segment"),
    ],
)
def test_contact_that_rods_refuse(settings: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plan", *ROD, *settings]) == 2
    assert words in capsys.readouterr().err


def test_contact_takes_memory_where_strands_are_many() -> None:
    """290 bytes a particle, 32 a cell that a segment lies in, about four, and 50 a pair of boxes that meet."""
    for strands, more in ((200, 1e6), (20_000, 105e6)):
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
    fall = np.where(np.arange(n) > 0, 9.81 / (scene.time.fps * scene.time.substeps) ** 2, 0)
    moved = x - fall[:, None] * np.array([0, 1, 0])
    ends = np.stack([x[:, :-1], x[:, 1:], moved[:, :-1], moved[:, 1:]])
    low, high = (ends.min(0) - 0.075).reshape(-1, 3), (ends.max(0) + 0.075).reshape(-1, 3)
    strand = np.repeat(np.arange(400), n - 1)
    meet = (low[:, None] <= high[None]).all(2) & (high[:, None] >= low[None]).all(2) & (strand[:, None] != strand)
    pairs = meet.sum() / 2
    assert pairs > 5000
    assert crowding_of(scene, 400).pairs == pytest.approx(pairs, rel=0.15)
    assert crowding_of(scene, 40 * crowding.STRANDS).pairs == 1600 * crowding_of(scene, crowding.STRANDS).pairs


def test_the_sample_is_turned_out_of_solids_as_before_the_first_step() -> None:
    """Out of a ball as far as edges reach, within a tenth of them; they keep their lengths, and others stay."""
    ball = "[{kind: sphere, radius: 0.99}, {kind: plane, position: [0, -1.2, 0]}]"
    settings = ("emitter.strands=300", "emitter.shape.radius=0.3", "emitter.position=[0, 0.1, 0]", f"solids={ball}")
    scene = load("minimal", rules=registry(), overrides=settings)
    groom, n = emit(scene.emitter, scene.seed), scene.emitter.particles
    x, held = crowding._turned_out(groom, scene.emitter, scene.solids)
    edge = groom.lengths / (n - 1)
    assert np.linalg.norm(np.diff(x, axis=1), axis=2) == pytest.approx(np.repeat(edge[:, None], n - 1, 1), rel=1e-6)
    far = np.linalg.norm(x, axis=2)
    reached = np.minimum(far[:, :1] + edge[:, None] * np.arange(n), 0.99)
    assert (far >= reached - 0.1 * edge[:, None]).all()
    assert x[:, :, 1].min() > -1.2 - 0.1 * edge.max()
    assert held[:, 0].all()
    assert not held[(far > 1.15) & (x[:, :, 1] > -1.15)].any()
    straight, _ = crowding._turned_out(groom, scene.emitter, ())
    way = groom.directions * groom.lengths[:, None]
    assert straight[:, -1] == pytest.approx(groom.roots + way + np.array([0, 0.1, 0]), abs=1e-5)


@pytest.mark.long
def test_pairs_and_cells_are_those_that_the_first_step_looks_at(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 9,000 strands that begin deep in a solid: within a sixth."""
    settings = (
        "emitter.strands=9000", "emitter.particles=10", "emitter.shape.radius=0.1", "time.preroll=0", "solver=rod",
        "rules=[gravity, collision, {contact: {}}]",
    )  # fmt: skip
    scene = load("minimal", rules=registry(), overrides=settings)
    solver, found = RodSolver(scene, emit(scene.emitter, scene.seed)), []
    assert solver.contact is not None

    class EndError(Exception):
        pass

    def fill(boxes: Any, side: float, starts: Any, entries: Any, cells: Any) -> None:
        found.append(len(entries))
        real(boxes, side, starts, entries, cells)

    def sort(self: Nearby, pairs: Any, total: int) -> None:
        found.append(len(pairs))
        raise EndError

    real = contact_pairs.fill_cells
    monkeypatch.setattr(contact_pairs, "fill_cells", fill)
    monkeypatch.setattr(Nearby, "_in_order", sort)
    with pytest.raises(EndError):
        solver.step(1 / 24, 1 / 24)
    cells, pairs = found
    told = crowding_of(scene, 9000)
    assert told.pairs == pytest.approx(pairs, rel=1 / 6)
    assert told.cells == pytest.approx(cells, rel=1 / 6)


def plan_of(preset: str, *overrides: str) -> Plan:
    return make_plan(load(preset, rules=registry(), overrides=overrides), [1])
