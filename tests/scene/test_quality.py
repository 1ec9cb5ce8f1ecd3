"""`quality`: what it sets, what wins over it."""

from __future__ import annotations

from pathlib import Path

import pytest

import strandcli
from strandcli.errors import StrandError
from strandcli.scene import SceneError, to_dict
from strandcli.scene.fields import value_at
from strandcli.scene.quality import QUALITIES, settings_for

TEXT = "extends: hair\nquality: best\nimage: {supersample: 3}\n"


@pytest.mark.parametrize("name", list(QUALITIES))
def test_a_quality_sets_its_settings(name: str) -> None:
    scene = strandcli.load("hair", overrides=[f"quality={name}"])
    assert scene.quality == name
    wanted = settings_for(name, scene)
    assert set(wanted) >= {"curves.level", "curves.tolerance", "image.supersample", "image.resolver"}
    for light, plain in zip(scene.lights, strandcli.load("hair").lights, strict=True):
        assert light.shadow.model == ("off" if plain.shadow.model == "off" else "opacity")
    for path, value in wanted.items():
        assert value_at(scene, path) == value


def test_single_settings_win_wherever_they_stand() -> None:
    for overrides in (["quality=draft", "image.supersample=5"], ["image.supersample=5", "quality=draft"]):
        scene = strandcli.load("hair", overrides=overrides)
        assert scene.image.supersample == 5
        assert (scene.curves.level, scene.curves.tolerance) == (2, 1.0)


def test_what_stands_beside_it_in_a_file_wins_and_what_is_extended_does_not(tmp_path: Path) -> None:
    path = tmp_path / "fine.yaml"
    path.write_text(TEXT)
    scene = strandcli.load(str(path))
    assert (scene.image.supersample, scene.curves.level) == (3, QUALITIES["best"]["curves.level"])
    path.write_text(TEXT.replace("image: {supersample: 3}\n", ""))
    assert strandcli.load(str(path)).image.supersample == QUALITIES["best"]["image.supersample"]
    path.write_text(TEXT.replace("best", "bets"))
    with pytest.raises(StrandError, match="bets"):
        strandcli.load(str(path))


def test_a_look_keeps_what_it_fixes() -> None:
    scene = strandcli.load("headline", overrides=["quality=best", "look=source"])
    assert (scene.image.resolver, scene.lights[0].shadow.model) == ("zbuffer", "minmax")
    assert scene.image.supersample == QUALITIES["best"]["image.supersample"]


def test_no_quality_changes_nothing() -> None:
    plain, named = strandcli.load("hair"), strandcli.load("hair", overrides=["quality=preset"])
    assert named == plain


COSTLY = """
extends: hair
image: {supersample: 4}
camera: {aperture: 0.02, samples: 64}
curves: {level: 6, tolerance: 0.05}
children: {count: 31}
material: {width: 0.0004}
detail: {near: 6, fraction: 0.5}
ambient_occlusion: {cells: 200000, directions: 128}
lights:
  - {kind: directional, shadow: {model: minmax}}
  - {kind: point, shadow: {model: opacity, size: 4096, layers: 61}}
  - {kind: point, shadow: {model: "off"}}
"""


def test_a_draft_cuts_what_a_preset_sets_itself(tmp_path: Path) -> None:
    path = tmp_path / "costly.yaml"
    path.write_text(COSTLY)
    scene = strandcli.load(str(path), settings={"quality": "draft"})
    assert (scene.image.supersample, scene.camera.samples) == (1, 4)
    assert (scene.curves.level, scene.curves.tolerance) == (2, 1.0)
    assert scene.children.count == 16
    assert scene.material.width == pytest.approx(0.0006)
    assert scene.detail.near == 3
    assert scene.detail.pixels == 1.0
    assert (scene.ambient_occlusion.cells, scene.ambient_occlusion.directions) == (10_000, 16)
    assert [light.shadow.model for light in scene.lights] == ["opacity", "opacity", "off"]
    assert [(light.shadow.size, light.shadow.layers) for light in scene.lights[:2]] == [(512, 15)] * 2


def test_a_draft_makes_nothing_finer_than_it_is(tmp_path: Path) -> None:
    path = tmp_path / "cheap.yaml"
    path.write_text(
        "children: {count: 1}\nmaterial: {width: 0.01}\ncamera: {samples: 2}\ncurves: {level: 1, tolerance: 3}\n"
        "detail: {pixels: 2}\nlights: [{kind: point, shadow: {size: 64, layers: 3}}]\n"
    )
    scene = strandcli.load(str(path), settings={"quality": "draft"})
    assert (scene.children.count, scene.material.width) == (1, 0.01)
    assert (scene.camera.samples, scene.curves.level, scene.curves.tolerance) == (2, 1, 3.0)
    assert (scene.detail.near, scene.detail.pixels) == (None, 2.0)
    assert (scene.lights[0].shadow.size, scene.lights[0].shadow.layers) == (64, 3)
    assert scene.ambient_occlusion is None


def test_another_quality_takes_the_place_of_the_one_before(tmp_path: Path) -> None:
    path = tmp_path / "draft.yaml"
    path.write_text("extends: hair\nquality: draft\n")
    for name in ("draft", "default", "best", "preset"):
        twice, once = strandcli.load(str(path), settings={"quality": name}), strandcli.load("hair", [f"quality={name}"])
        assert to_dict(twice) == to_dict(once)
    (tmp_path / "twice.yaml").write_text("extends: draft.yaml\nquality: draft\n")
    assert to_dict(strandcli.load(str(tmp_path / "twice.yaml"))) == to_dict(strandcli.load("hair", ["quality=draft"]))


FAULTY = [
    "lights: [{kind: nope}]", "image: 3", "children: {count: many}", "detail: [1]",
    "lights: [{kind: point, shadow: 3}]", "lights: {}",
]  # fmt: skip


@pytest.mark.parametrize("faulty", FAULTY)
def test_a_quality_beside_a_fault_leaves_the_fault_to_be_told(faulty: str, tmp_path: Path) -> None:
    path = tmp_path / "faulty.yaml"
    path.write_text(f"quality: draft\n{faulty}\n")
    with pytest.raises(SceneError) as told:
        strandcli.load(str(path))
    assert {fault.line for fault in told.value.faults} == {2}
    (tmp_path / "base.yaml").write_text(f"{faulty}\n")
    path.write_text("extends: base.yaml\nquality: draft\n")
    with pytest.raises(SceneError):
        strandcli.load(str(path))
    with pytest.raises(SceneError):
        strandcli.load(str(tmp_path / "base.yaml"), overrides=["quality=draft"])
