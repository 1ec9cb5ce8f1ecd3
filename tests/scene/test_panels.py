"""Panels: complete scenes with a few settings changed."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from scene_kit import RULES, complaint, complaints, scene
from strandcli.scene import load

TEXT = """\
title: wind
rules: [gravity, wind: {strength: 2}]
camera: {position: [0, 1, 4]}
panels:
  - label: calm
    set: {wind.strength: 0, image.size: [10, 20]}
  - label: storm
    set:
      wind: {strength: 50}
      camera: {target: [0, 1, 0], fov: 30}
      emitter.shape: {kind: disc}
  - {}
"""


def test_a_panel_is_the_scene_with_its_settings() -> None:
    got = scene(TEXT)
    calm, storm, same = got.panels
    assert [panel.label for panel in got.panels] == ["calm", "storm", ""]
    assert [panel.rules[1].parameters.strength for panel in got.panels] == [0.0, 50.0, 2.0]
    assert (calm.image.size, storm.image.size) == ((10, 20), (800, 600))
    assert (storm.camera.position, storm.camera.target, storm.camera.fov) == ((0.0, 1.0, 4.0), (0.0, 1.0, 0.0), 30.0)
    assert storm.emitter.shape.kind == "disc"
    assert all(panel.title == "wind" and panel.panels == () for panel in got.panels)
    assert same == dataclasses.replace(got, panels=())


def test_a_panel_changes_lists_of_rules() -> None:
    text = "rules: [gravity, wind, elasticity]\npanels:\n- set: {rules: %s}\n"
    assert [use.name for use in scene(text % "[wind]").panels[0].rules] == ["wind"]
    assert [use.name for use in scene(text % "{wind: null}").panels[0].rules] == ["gravity", "elasticity"]
    assert scene(text % "[]").panels[0].rules == ()


@pytest.mark.parametrize(
    ("panels", "says"),
    [
        ("{label: a}", "p.yaml:2:9: panels: must be a list of panels, not a mapping"),
        ("[{lable: a}]", "p.yaml:2:11: panels.0.lable: unknown key; did you mean 'label'?"),
        ("[{set: {panels: []}}]", "p.yaml:2:17: panels.0.set.panels: a panel cannot have this; panels do not nest"),
        ("[{}, {set: {wind.strenght: 3}}]", "p.yaml:2:21: panels.1.set.wind.strenght: unknown key; did you mean"),
        ("[{set: {wind.strength: -1}}]", "p.yaml:2:32: panels.0.set.wind.strength: must be a number of at least 0"),
        ("[{set: {gravity.acceleration: [0, 0, 0]}}]", "the preset does not list the rule 'gravity'"),
        ("[{set: {camera.position: [0, 0, 0]}}]", "p.yaml:2:34: panels.0.set.camera.position: the camera stands at"),
        ("[{set: {solids: [{kind: box, name: a}, {kind: box, name: a}]}}]", "panels.0.set.solids.1.name: solids.0 has"),
    ],
)
def test_faults_of_panels_stand_at_the_panel(panels: str, says: str) -> None:
    assert says in complaint(f"rules: [wind]\npanels: {panels}\n")


def test_faults_of_the_scene_are_not_told_again_for_each_panel() -> None:
    lines = complaints("time: {fps: 0}\nsed: 1\npanels: [{}, {}, {set: {seed: -1}}]\n")
    assert [line.split(":")[1] for line in lines] == ["1", "2", "3"]


def test_overrides_change_the_scene_and_a_panel_has_the_last_word(tmp_path: Path) -> None:
    path = tmp_path / "p.yaml"
    path.write_text(TEXT)
    got = load(path, rules=RULES, overrides=["wind.strength=9", "seed=4"], settings={"image.size": (30, 40)})
    assert [panel.rules[1].parameters.strength for panel in got.panels] == [0.0, 50.0, 9.0]
    assert [panel.image.size for panel in got.panels] == [(10, 20), (30, 40), (30, 40)]
    assert {panel.seed for panel in got.panels} == {4}
    assert {(panel.source, panel.sha256) for panel in got.panels} == {(str(path), got.sha256)}


def test_panels_are_inherited_as_a_list(tmp_path: Path) -> None:
    (tmp_path / "base.yaml").write_text(TEXT)
    path = tmp_path / "p.yaml"
    path.write_text("extends: base.yaml\nseed: 3\n")
    assert [panel.seed for panel in load(path, rules=RULES).panels] == [3, 3, 3]
    path.write_text("extends: base.yaml\npanels: null\n")
    assert load(path, rules=RULES).panels == ()
