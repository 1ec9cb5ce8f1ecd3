"""`quality`: what it sets, what wins over it."""

from __future__ import annotations

from pathlib import Path

import pytest

import strandcli
from strandcli.errors import StrandError
from strandcli.scene.quality import QUALITIES, settings_for
from strandcli.study.pictures.subject import value_at

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
        assert scene.curves.level == QUALITIES["draft"]["curves.level"]


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
