"""Rules in a preset: a list in its own order, a mapping in the default order."""

from __future__ import annotations

import pytest

from scene_kit import Breeze, Bump, Gust, Pull, complaint, complaints, scene
from strandcli.scene import RuleUse


def names(text: str) -> list[str]:
    return [use.name for use in scene(text).rules]


def test_a_mapping_takes_the_default_order() -> None:
    text = "rules:\n  elasticity:\n  collision: {}\n  wind: {strength: 2}\n  gravity:\n"
    assert names(text) == ["gravity", "wind", "collision", "elasticity"]


def test_null_leaves_a_rule_of_a_mapping_out_and_means_nothing_in_a_list() -> None:
    assert names("rules: {gravity: null, wind: {}}") == ["wind"]
    assert names("rules: [gravity: null]") == ["gravity"]


def test_parameters_are_read_with_their_defaults() -> None:
    rules = scene("rules: [gravity, wind: {strength: 2, gusts: [{time: 1}]}, collision: {segments: true}]").rules
    assert rules == (
        RuleUse("gravity", Pull(), "gravity"),
        RuleUse("wind", Breeze(strength=2.0, gusts=(Gust(1.0),)), "wind"),
        RuleUse("collision", Bump(segments=True), "collision"),
    )


def test_a_key_that_python_keeps_for_itself() -> None:
    text = "solids: [{kind: box, name: a}, {kind: box, name: b}]\nrules: [collision: {with: %s}]"
    assert scene(text % "a").rules[0].parameters.with_ == ("a",)
    assert scene(text % "[a, b]").rules[0].parameters.with_ == ("a", "b")
    assert "collision.with: must be a name or a list of names, not a mapping" in complaint(text % "{a: 1}")
    assert "with_: unknown key; did you mean 'with'?" in complaint("rules: [collision: {with_: a}]")


def test_the_same_rule_twice_is_told_apart_in_messages() -> None:
    text = "rules:\n- wind: {strength: 1}\n- gravity\n- wind: {strength: -1}\n- wind: {octaves: 0}\n"
    assert [line.split(": must")[0] for line in complaints(text)] == [
        "p.yaml:4:20: wind[2].strength",
        "p.yaml:5:19: wind[3].octaves",
    ]
    assert [use.path for use in scene("rules: [wind, gravity, wind]").rules] == ["wind", "gravity", "wind[2]"]


def test_an_unknown_rule_is_put_right_and_all_are_named() -> None:
    known = "The rules are elasticity, gravity, wind, collision"
    assert complaint("rules: [gravty]") == f"p.yaml:1:9: rules: unknown rule 'gravty'; did you mean 'gravity'? {known}"
    assert complaint("rules: {zzz: 3}") == f"p.yaml:1:9: rules: unknown rule 'zzz'; {known[0].lower()}{known[1:]}"
    assert complaint("rules: {wind: {}, gravty: {}}").startswith("p.yaml:1:19: rules: unknown rule 'gravty'")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("rules: wind", "must be a list or a mapping of rules, not 'wind'"),
        ("rules: [[wind]]", "rules.0: must be a rule's name or `name: {setting: value}`, not '[wind]'"),
        ("rules: [null]", "rules.0: must be a rule's name"),
        ("rules:\n- wind:\n  strength: 3\n", "if 'strength' is a setting of 'wind', indent it further"),
        ("rules: [wind: 3]", "wind: must be a mapping of settings, not '3'"),
    ],
)
def test_what_is_no_rule(text: str, says: str) -> None:
    assert says in complaint(text)


def test_a_rule_may_look_at_the_whole_scene() -> None:
    text = "solids:\n- {kind: sphere, name: head}\nrules:\n- collision: {with: [head, hat]}\n- collision: {with: bed}\n"
    assert complaints(text) == [
        "p.yaml:4:28: collision.with.1: no solid has the name 'hat'",
        "p.yaml:5:21: collision[2].with.0: no solid has the name 'bed'",
    ]
