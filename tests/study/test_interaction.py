"""The axis of interaction: cells, and guides that stand for more strands."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cli_runs import Runner
from strand_kit import scene_of
from strandcli.errors import UsageError
from strandcli.groom.emit import emit
from strandcli.study import sweep
from strandcli.study.axes import Request
from strandcli.study.motion.hairs import Hairs, Ruler, elsewhere, in_cells
from strandcli.study.motion.interaction import Interaction
from strandcli.study.registry import find

TUFT = """
title: a tuft that falls over
solver: rod
time: {frames: 6, preroll: 0.25}
rod: {radius: 1.0e-4}
emitter: {shape: {kind: disc, radius: 0.03}, strands: 64, particles: 6, length: 0.12, jitter: 10, direction: [1, 1, 0]}
children: {count: 8}
image: {size: [48, 32]}
rules: [gravity, interaction: {density: 3.0e+5, cell: 0.02}]
"""


def opened(text: str = TUFT, **wishes: Any) -> Interaction:
    return Interaction(Request(scene=scene_of(text), name="tuft", **wishes))


def test_all_settings_have_the_same_hair() -> None:
    study = opened(guides=(16, 32), cells=(0.02, 0.03))
    assert study.total == 64 * 8
    assert len(study.settings()) == 4
    for parameters in (*study.settings(), *study.finer(study.turned[0])):
        assert parameters["emitter.strands"] * parameters["children.count"] == 512
        scene = study.scene_with(parameters)
        assert scene.drawn_strands == 512
        solver_metres = emit(scene.emitter, scene.seed).lengths.sum() * scene.children.count  # type: ignore[union-attr]
        assert solver_metres == pytest.approx(512 * 0.12, rel=1e-5)
    assert study.finer(study.turned[0])[-1] == {
        "emitter.strands": 64,
        "children.count": 8,
        "rules.interaction.cell": 0.01,
    }


def test_one_is_turned_and_the_other_stays() -> None:
    assert opened(cells=(0.02,)).settings() == [{"rules.interaction.cell": 0.02}]
    assert opened(guides=(8,)).settings() == [{"emitter.strands": 8, "children.count": 64}]
    usual = opened()
    each = usual.settings()
    assert [parameters["rules.interaction.cell"] for parameters in each[:5]] == [0.08, 0.0566, 0.04, 0.0283, 0.02]
    assert [parameters["emitter.strands"] for parameters in each[5:8]] == [16, 32, 64]
    assert each[8:] == [{"rod.iterations": count} for count in (1, 2, 4, 8)]
    assert [usual.finer(one)[-1] for one in usual.turned] == [
        {"rules.interaction.cell": 0.01}, {"emitter.strands": 128, "children.count": 4}, {"rod.iterations": 16}
    ]  # fmt: skip
    together = opened(iterations=(2,), cells=(0.02, 0.04), guides=(8, 16))
    assert len(together.settings()) == 4
    assert together.turned[0].name == "rod"


def test_of_strands_that_touch_each_stands_for_itself() -> None:
    """With the rule contact guides are not turned, unless they are asked for."""
    study = opened(TUFT.replace("rules: [", "rules: [contact: {}, "))
    assert [one.name for one in study.turned] == ["cells", "iterations"]


def test_cells_that_are_wider_than_the_hair_is_long_are_left_out() -> None:
    assert opened(TUFT.replace("cell: 0.02", "cell: 0.05")).turned[0].values["rules.interaction.cell"] == (
        0.1,
        0.0707,
        0.05,
    )


def test_without_children_guides_stand_for_the_strands() -> None:
    text = TUFT.replace("children: {count: 8}\n", "")
    study = opened(text, guides=(16, 32))
    assert study.finer(study.turned[0])[-1] == {"emitter.strands": 64, "children.count": 1}
    assert study.settings()[0] == {"emitter.strands": 16, "children.count": 4}


def test_a_hair_at_a_guide_is_the_guide_and_moves_with_all() -> None:
    """Between guides that all move alike it moves so, too, at its own length."""
    scene = scene_of(TUFT.replace("length: 0.12", "length: 0.12, length_variation: 0.3"))
    hairs = Hairs(scene, 64)
    groom = emit(scene.emitter, scene.seed, 16)
    way = np.linspace(0, 1, 9)[:, None] ** 2 * np.array([0.3, -0.2, 0.9])
    points = groom.roots[:, None] + groom.lengths[:, None, None] * way + 0.01
    found = hairs.led_by(16, points[None].astype(np.float64))
    np.testing.assert_allclose(found[0], np.broadcast_to(way, found[0].shape), atol=1e-6)
    other = points[None] + np.random.default_rng(0).normal(size=points.shape)
    ways = (other - other[:, :, :1]) / groom.lengths[:, None, None]
    np.testing.assert_allclose(hairs.led_by(16, other)[:, :16], ways, atol=1e-9)


def test_hair_in_cells_is_all_of_it() -> None:
    points = np.random.default_rng(1).uniform(0.1, 0.7, (20, 33, 3))
    metres = np.linspace(1, 2, 20)
    found = in_cells(points, metres, 0.1, np.zeros(3), (9, 9, 9))
    assert found.sum() == pytest.approx(metres.sum())
    z, y, x = np.meshgrid(*(0.1 * np.arange(9),) * 3, indexing="ij")
    middle = [float((found * axis.ravel()).sum() / found.sum()) for axis in (x, y, z)]
    share = np.ones(33) / 32
    share[[0, -1]] /= 2
    np.testing.assert_allclose(middle, np.einsum("s,p,spc->c", metres / metres.sum(), share, points), rtol=1e-9)
    assert elsewhere(found, found) == 0
    assert elsewhere(np.array([1.0, 0, 0]), np.array([0, 2.0, 2.0])) == 1


@pytest.mark.long
@pytest.mark.parametrize("preset", ["hair", "ponytail"])
def test_more_guides_of_a_preset_come_nearer(preset: str) -> None:
    from strandcli import load

    request = Request(scene=load(preset), name=preset, guides=(90, 180, 360), span=0.5)
    found = [point.error["mean"] for point in sweep.run(find("interaction"), request).points]
    assert found == sorted(found, reverse=True)  # type: ignore[type-var]


def test_each_axis_has_a_reference_that_it_comes_nearer_to() -> None:
    """And what a run has of itself: in coarser cells more of the hair stays denser than allowed. More iterations than
    some change nothing."""
    text = TUFT.replace("density: 3.0e+5, cell: 0.02", "density: 1.0e+5, cell: 0.02")
    study = sweep.run(find("interaction"), Request(scene=scene_of(text), name="tuft"))
    assert list(study.reference["limits"]) == list(study.margins) == ["cells", "guides", "iterations"]
    errors = {name: [one.error for one in study.points if one.solver == name] for name in study.margins}
    assert any(one["in"] == "spacing" and one["order"] for one in study.orders)
    for name, found in errors.items():
        away = [one["elsewhere"] for one in found]
        assert all(b <= 1.02 * a for a, b in pairwise(away)), name  # type: ignore[operator]
        assert away[-1] < 0.5 * away[0] or (name == "iterations" and not any(away)), name  # type: ignore[operator]
        assert study.reference["limits"][name]["converges"], name
    assert errors["iterations"][-1]["elsewhere"] == 0
    over = [one["too_dense"] for one in errors["cells"]]
    assert over[0] > 1.5 * over[-1] > 0  # type: ignore[operator]


def test_what_is_too_dense_is_measured_in_the_same_cells() -> None:
    """Three metres in a cell that may hold two."""
    ruler = Ruler(1.0, 2.0, 0.0)
    assert ruler.too_dense([np.array([3.0, 1.0]), np.array([2.0, 2.0])]) == pytest.approx(1 / 8)
    assert Ruler(1.0, None, 0.0).too_dense([np.ones(2)]) is None


@pytest.mark.parametrize(
    ("change", "wishes", "words"),
    [
        (("interaction: {density: 3.0e+5, cell: 0.02}", "emitter_motion"), {"cells": (0.1,)}, "lists no rule interact"),
        (("interaction: {density: 3.0e+5, cell: 0.02}", "emitter_motion"), {}, "lists no rule interaction"),
        (("density: 3.0e+5, ", ""), {"cells": (0.02,)}, "has no density"),
        (("rules: [", "rules: [contact: {}, "), {"guides": (8,)}, "by rule contact strands touch as they are"),
        (("", ""), {"cells": (1e-5,)}, "less than a strand's thickness"),
        (("", ""), {"cells": (2.0,)}, "larger than the groom"),
        (("", ""), {"guides": (257,)}, "name at most 256"),
        (("count: 8", "count: 10000"), {"guides": (8,)}, "more than 10,000 strands each of the 640,000"),
    ],
)
def test_what_cannot_be_studied_is_told_in_one_line(
    change: tuple[str, str], wishes: dict[str, Any], words: str
) -> None:
    with pytest.raises(UsageError, match=words) as raised:
        opened(TUFT.replace(*change), **wishes)
    assert "\n" not in str(raised.value)


def test_guides_need_no_interaction() -> None:
    study = opened(TUFT.replace("interaction: {density: 3.0e+5, cell: 0.02}", "emitter_motion"), guides=(8, 16))
    assert len(study.settings()) == 2


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Runner:
    (tmp_path / "tuft.yaml").write_text(TUFT)
    monkeypatch.chdir(tmp_path)
    return Runner(tmp_path, capsys)


def test_the_command_names_what_to_set(run: Runner) -> None:
    done = run("study", "tuft.yaml", "--guides", "16,32", "--cells", "0.02,0.03", "--no-progress", "--max-error", "50%")
    assert done.code == 0, done.err
    assert "under 50 %: emitter.strands=" in done.out
    assert "limit of rod:" in done.out
    data = json.loads(Path("out/study/tuft-interaction.json").read_text())
    assert data["axis"] == "interaction"
    assert len(data["points"]) == 4
    assert {"mean", "elsewhere", "denser"} <= set(data["points"][0]["error"])
    assert "16 guides" in Path("out/study/tuft-interaction.svg").read_text()
    missed = run("study", "tuft.yaml", "--guides", "8", "--no-progress", "--max-error", "0.01%", "--overwrite", "-q")
    assert missed.code == 3
    assert missed.error().endswith("try finer --cells or more --guides")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["tuft.yaml", "--cells", "0"], "'0' is not a length above 0"),
        (["tuft.yaml", "--cells", "-0.1"], "not a length above 0"),
        (["tuft.yaml", "--cells", "nan"], "not a length above 0"),
        (["tuft.yaml", "--guides", "0"], "from 1 to"),
        (["tuft.yaml", "--guides", "8", "--strands", "3"], "axis interaction; name --guides"),
        (["tuft.yaml", "--cells", "0.02", "--substeps", "2"], "axis interaction; use --set"),
        (["tuft.yaml", "--axis", "motion", "--cells", "0.02"], "--cells does not go with axis motion"),
        (["tuft.yaml", "--axis", "shadow", "--guides", "8"], "--guides does not go with axis shadow"),
        (["tuft.yaml", "--axis", "interaction", "--frame", "2"], "name an --axis of pictures"),
        (["--reference", "beam", "--cells", "0.02"], "--cells is for presets"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(run: Runner, arguments: list[str], words: str) -> None:
    done = run("study", *arguments)
    assert done.code == 2, done.err
    assert words in done.error()
    assert not Path("out").exists()
