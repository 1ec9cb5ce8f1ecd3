"""`extends`: what is merged, replaced and deleted, and chains of presets."""

from __future__ import annotations

from pathlib import Path

import pytest

from scene_kit import RULES, changed, fails, make_library, refused, write
from strandcli.scene import load
from strandcli.scene.model import DirectionalLight, DiscShape, SphereShape


@pytest.fixture(autouse=True)
def shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """`make_library`."""
    return make_library(tmp_path, monkeypatch)


def test_extends_merges_mappings_replaces_lists_and_deletes_by_null() -> None:
    write(
        "base.yaml",
        """
        seed: 3
        camera: {fov: 20, height: 7}
        detail: {near: 3}
        lights: [{kind: point}, {kind: point}]
        emitter: {shape: {kind: sphere, cap: 90, radius: 2}, strands: 5}
        """,
    )
    got = changed(
        """
        extends: base.yaml
        camera: {fov: 30, height: null}
        detail: null
        lights: [{kind: directional}]
        emitter: {shape: {radius: 3}}
        """
    )
    assert (got.seed, got.camera.fov, got.camera.height) == (3, 30.0, 3.0)
    assert got.detail is None
    assert got.lights == (DirectionalLight(),)
    assert got.emitter.shape == SphereShape(cap=90.0, radius=3.0)
    assert got.emitter.strands == 5


def test_another_kind_of_shape_inherits_nothing_from_the_first() -> None:
    write("base.yaml", "emitter: {shape: {kind: sphere, cap: 90}}")
    assert changed("extends: base.yaml\nemitter: {shape: {kind: disc}}").emitter.shape == DiscShape()


def test_extends_is_relative_to_the_file_and_names_are_shipped() -> None:
    write("a/b/one.yaml", "extends: ../two.yaml\n")
    write("a/two.yaml", "extends: hair\nseed: 2\n")
    got = load("a/b/one.yaml", rules=RULES)
    assert (got.title, got.seed) == ("shipped hair", 2)
    assert load("figures/fig03", rules=RULES).title == "figure 2"


def test_rules_inherited() -> None:
    write("list.yaml", "rules: [wind: {strength: 2, octaves: 5}, gravity]")
    write("map.yaml", "rules: {wind: {strength: 2, octaves: 5}, gravity: }")
    for base in ("list.yaml", "map.yaml"):
        replaced = changed(f"extends: {base}\nrules: [elasticity]")
        assert [use.name for use in replaced.rules] == ["elasticity"]
        patched = changed(f"extends: {base}\nrules: {{wind: {{strength: 3}}, gravity: null}}")
        assert [use.name for use in patched.rules] == ["wind"]
        wind = patched.rules[0].parameters
        assert (wind.strength, wind.octaves) == (3.0, 5)
    added = changed("extends: map.yaml\nrules: {elasticity: }")
    assert [use.name for use in added.rules] == ["gravity", "wind", "elasticity"]
    message = refused("extends: list.yaml\nrules: {elasticity: }")
    assert message.startswith("p.yaml:2:1: rules: the preset does not list the rule 'elasticity'")


def test_faults_name_the_file_in_which_the_value_stands() -> None:
    write("base.yaml", "seed: 1\ncamera:\n  fov: 200\n  positon: [0, 0, 1]\n")
    assert refused("extends: base.yaml\ncamera:\n  near: 0\ntme: 3\n").splitlines() == [
        "p.yaml:3:9: camera.near: must be a number above 0 (m), not '0'",
        "p.yaml:4:1: tme: unknown key; did you mean 'time'?",
        "base.yaml:3:8: camera.fov: must be a number above 0 and below 180 (deg), not '200'",
        "base.yaml:4:3: camera.positon: unknown key; did you mean 'position'?",
    ]


def test_circles_and_long_chains_are_refused_with_their_names() -> None:
    write("a.yaml", "extends: b.yaml\n")
    write("b.yaml", "extends: ./a.yaml\n")
    assert fails("a.yaml") == "b.yaml:1:10: extends: goes in a circle: a.yaml -> b.yaml -> ./a.yaml"
    write("self.yaml", "extends: self.yaml\n")
    assert "goes in a circle: self.yaml -> self.yaml" in fails("self.yaml")
    write("n0.yaml", "seed: 8\n")
    for n in range(1, 10):
        write(f"n{n}.yaml", f"extends: n{n - 1}.yaml\n")
    assert load("n8.yaml", rules=RULES).seed == 8
    assert "goes more than 8 deep: n9.yaml -> n8.yaml -> n7.yaml" in fails("n9.yaml")


@pytest.mark.parametrize(
    ("extends", "says"),
    [
        ("hiar", "p.yaml:1:10: extends: no preset 'hiar'; did you mean 'hair'?"),
        ("nothing.yaml", "p.yaml:1:10: extends: no preset 'nothing.yaml'"),
        ("[a]", "must be the name or the path of a preset, not a list"),
        ("", "must be the name or the path of a preset, not nothing"),
        ('"a\\0.yaml"', "control character"),
    ],
)
def test_what_cannot_be_extended(extends: str, says: str) -> None:
    assert says in refused(f"extends: {extends}\n")


def test_syntax_errors_of_an_extended_file_are_told_with_faults_above() -> None:
    write("base.yaml", "title: [\n")
    lines = refused("extends: base.yaml\nseed: 1\nseed: 2\n").splitlines()
    assert [line.split(":")[0] for line in lines] == ["p.yaml", "base.yaml"]
