"""Names and paths, `extends`, `--set`, settings from Python, and the hash of it all."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from scene_kit import RULES, complaint, scene
from strandcli.errors import UsageError
from strandcli.scene import Scene, library, load
from strandcli.scene.chain import hidden_by_shipped
from strandcli.scene.model import Detail, DirectionalLight, DiscShape, PointLight, SphereShape


@pytest.fixture(autouse=True)
def shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A library of three presets, and an own folder to work in."""
    presets = tmp_path / "presets"
    (presets / "figures").mkdir(parents=True)
    (presets / "hair.yaml").write_text("title: shipped hair\nseed: 7\n")
    (presets / "figures" / "fig02.yaml").write_text("title: figure 2\n")
    (presets / "figures" / "fig03.yaml").write_text("extends: figures/fig02\nseed: 3\n")
    monkeypatch.setattr(library, "folder", lambda: presets)
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.chdir(work)
    return presets


def write(name: str, text: str) -> str:
    path = Path(name)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return name


def fails(name: str, *overrides: str, **settings: object) -> str:
    with pytest.raises(UsageError) as caught:
        load(name, rules=RULES, overrides=overrides, settings=settings)
    assert caught.value.exit_code == 2
    return str(caught.value)


def changed(text: str, *overrides: str) -> Scene:
    return load(write("p.yaml", text), rules=RULES, overrides=overrides)


def refused(text: str, *overrides: str) -> str:
    return fails(write("p.yaml", text), *overrides)


# names and paths


def test_shipped_names_and_paths(shipped: Path) -> None:
    assert load("hair", rules=RULES).title == "shipped hair"
    assert load("figures/fig02", rules=RULES).source == str(shipped / "figures" / "fig02.yaml")
    write("hair.yaml", "title: mine\n")
    assert load("hair.yaml", rules=RULES).title == "mine"
    assert load(Path("hair.yaml").absolute(), rules=RULES).title == "mine"
    assert load("hair", rules=RULES).title == "shipped hair"


def test_a_bare_name_is_a_file_here_too() -> None:
    write("bob.yaml", "title: bob\n")
    write("deep/jim.yml", "title: jim\nextends: base\n")
    write("deep/base.yaml", "seed: 5\n")
    assert load("bob", rules=RULES).title == "bob"
    got = load("deep/jim", rules=RULES)
    assert (got.title, got.seed) == ("jim", 5)
    Path("bob").mkdir()
    assert load("bob", rules=RULES).title == "bob"
    write("base.yaml", "extends: hair\n")
    write("hair.yaml", "title: mine\n")
    assert load("base", rules=RULES).title == "shipped hair"


def test_a_file_that_a_shipped_name_hides_is_found() -> None:
    assert hidden_by_shipped("hair") is None
    write("hair.yaml", "title: mine\n")
    write("bob.yaml", "title: bob\n")
    assert hidden_by_shipped("hair") == Path("hair.yaml")
    assert hidden_by_shipped("hair.yaml") is None
    assert hidden_by_shipped("bob") is None


def test_a_preset_that_is_not_there() -> None:
    listing = "`strandcli presets list` shows what is shipped"
    assert fails("hiar") == f"no preset 'hiar'; did you mean 'hair'? {listing}"
    assert fails("fig02") == f"no preset 'fig02'; did you mean 'figures/fig02'? {listing}"
    assert fails("zzzzzz") == f"no preset 'zzzzzz'; {listing}"
    write("my/scene.yaml", "seed: 1")
    assert "did you mean 'my/scene.yaml'?" in fails("my/scen.yaml")


@pytest.mark.parametrize("name", ["", "\0", "a\0b.yaml", "x" * 5000, "x" * 5000 + ".yaml", "../hair", "/", "a\nb", "~"])
def test_strange_names_are_no_presets(name: str) -> None:
    message = fails(name)
    assert len(message.splitlines()) == 1
    assert len(message) < 300


def test_a_folder_is_no_preset() -> None:
    Path("d.yaml").mkdir()
    assert "'d.yaml' is a folder" in fails("d.yaml")


def test_what_is_neither_file_nor_folder_is_no_preset() -> None:
    os.mkfifo("pipe.yaml")
    Path("lost.yaml").symlink_to("nowhere.yaml")
    for name in ("pipe.yaml", "lost.yaml", os.devnull):
        assert f"'{name}' is a device, a pipe or a link to nowhere" in fails(name)


def test_a_preset_that_cannot_be_read(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    write("p.yaml", "seed: 1")
    monkeypatch.setattr(Path, "open", refuse)
    assert fails("p.yaml") == "'p.yaml' cannot be read: Permission denied"


def test_the_size_is_capped_before_all_is_read() -> None:
    with Path("big.yaml").open("wb") as file:
        file.truncate(1 << 40)  # a sparse terabyte
    assert fails("big.yaml") == "big.yaml:1:1: is larger than 1048576 bytes; is it a preset?"


# extends


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


def test_extending_by_an_empty_mapping_changes_nothing() -> None:
    write("base.yaml", "camera: {fov: 20}\nrules: [wind]\n")
    got = changed("extends: base.yaml\ncamera:\nrules:\n")
    assert got.camera.fov == 20.0
    assert len(got.rules) == 1


def test_another_kind_of_shape_inherits_nothing_from_the_first() -> None:
    write("base.yaml", "emitter: {shape: {kind: sphere, cap: 90}}")
    assert changed("extends: base.yaml\nemitter: {shape: {kind: disc}}").emitter.shape == DiscShape()


def test_extends_is_relative_to_the_file_and_names_are_shipped() -> None:
    write("a/b/one.yaml", "extends: ../two.yaml\n")
    write("a/two.yaml", "extends: hair\nseed: 2\n")
    got = load("a/b/one.yaml", rules=RULES)
    assert (got.title, got.seed) == ("shipped hair", 2)
    assert load("figures/fig03", rules=RULES).title == "figure 2"


def test_a_deleted_key_may_be_given_again_further_down() -> None:
    write("one.yaml", "detail: {near: 3, fraction: 0.5}")
    write("two.yaml", "extends: one.yaml\ndetail: null\n")
    assert changed("extends: two.yaml\ndetail: {near: 4}").detail == Detail(near=4.0)


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


def test_extends_null_is_no_extends() -> None:
    assert changed("extends: null\nseed: 3").seed == 3


# overrides

BASE = """
seed: 1
rules: [gravity, wind: {strength: 2}, wind, elasticity]
solids: [{kind: sphere, name: head}, {kind: box, name: "1x"}]
lights: [{kind: point}, {kind: directional}]
"""


def test_overrides_reach_everything() -> None:
    got = changed(
        BASE,
        "seed=5",
        "camera.position=[1, 2, 3]",
        "camera.position.1=4",
        "emitter.shape.kind=disc",
        "emitter.shape.radius=2",
        "lights.0.intensity=1e1",
        "lights.0.shadow.model=off",
        "solids.head.radius=3",
        "solids.1.size=[1, 2, 3]",
        "wind.strength=3",
        "wind[2].strength=4",
        "rules.gravity.acceleration.1=-1",
        "detail.near=5",
        "image.size=640x480",
        "title=Wind: strong",
        "material.colour=#ffffff",
    )
    assert (got.seed, got.camera.position, got.image.size) == (5, (1.0, 4.0, 3.0), (640, 480))
    assert got.detail == Detail(near=5.0)
    assert got.emitter.shape == DiscShape(radius=2.0)
    assert got.lights[0] == PointLight(intensity=10.0, shadow=got.lights[0].shadow)
    assert (got.lights[0].shadow.model, got.lights[1].shadow.model) == ("off", "minmax")
    assert (got.solids[0].radius, got.solids[1].size) == (3.0, (1.0, 2.0, 3.0))  # type: ignore[union-attr]
    gravity, wind, wind2, _ = (use.parameters for use in got.rules)
    assert (gravity.acceleration, wind.strength, wind2.strength) == ((0.0, -1.0, 0.0), 3.0, 4.0)
    assert (got.title, got.material.colour) == ("Wind: strong", (1.0, 1.0, 1.0))


def test_overrides_of_mappings_merge_and_null_deletes() -> None:
    got = changed(BASE + "camera: {fov: 20, height: 4}", "camera={fov: 30}", "rules.wind[2]=null", "gravity=null")
    assert (got.camera.fov, got.camera.height) == (30.0, 4.0)
    assert [(use.name, use.parameters.strength) for use in got.rules[:1]] == [("wind", 2.0)]
    assert len(got.rules) == 2
    assert changed(BASE, "rules=[elasticity]").rules[0].name == "elasticity"
    assert changed(BASE, "solids=[]").solids == ()
    assert changed("rules: {wind: {}, gravity: {}}", "wind=null").rules[0].name == "gravity"


def test_an_override_reaches_into_defaults() -> None:
    got = changed("seed: 1", "lights.0.intensity=5", "camera.position.2=9")
    assert got.lights == (DirectionalLight(intensity=5.0),)
    assert got.camera.position == (0.0, 0.0, 9.0)


def test_later_overrides_win() -> None:
    assert changed(BASE, "seed=2", "seed=3").seed == 3


def test_an_equals_sign_may_stand_in_a_value() -> None:
    assert changed(BASE, "title=a=b").title == "a=b"


def test_an_override_mends_a_value_of_the_file() -> None:
    assert changed("camera: {fov: 500}", "camera.fov=50").camera.fov == 50.0


def test_another_kind_by_an_override_keeps_what_both_kinds_have() -> None:
    got = changed("emitter: {shape: {kind: sphere, cap: 90, radius: 3}}", "emitter.shape.kind=disc")
    assert got.emitter.shape == DiscShape(radius=3.0)


@pytest.mark.parametrize(
    ("override", "says"),
    [
        ("wind.strenght=3", "unknown key; did you mean 'strength'?"),
        ("sed=3", "unknown key; did you mean 'seed'?"),
        ("strands=5", "unknown key; did you mean 'emitter.strands'?"),
        ("strnds=5", "unknown key; did you mean 'emitter.strands'?"),
        ("fov=5", "unknown key; did you mean 'camera.fov'?"),
        ("wnd.strength=3", "unknown key; did you mean 'wind'?"),
        ("rules.wnd.strength=3", "unknown rule 'wnd'; did you mean 'wind'?"),
        ("collision.segments=true", "the preset does not list the rule 'collision'; its rules are gravity, wind, wind"),
        ("wind[3].strength=3", "the preset does not list the rule 'wind' 3 times; its rules are gravity, wind, wind"),
        ("time.fps=0", "must be a number above 0 and of at most 100000 (1/s), not '0'"),
        ("time.fps=12:30", "base 60"),
        ("time.fps=1_000", "write 1000"),
        ("time.fps=no", "not 'no'"),
        ("time.fps=.nan", "must be finite"),
        ("time.fps=010", "leading zero"),
        ("time.fps=", "not nothing"),
        ("time.fps='24'", "take the quotes away"),
        ("time.fps.x=3", "there is nothing inside this setting"),
        ("camera.position.x=3", "no entry of this list has the name 'x'"),
        ("camera.position.3=3", "there is no entry 3 in this list; it has 3, counted from 0"),
        ("camera.position.0.0=3", "there is nothing inside a number"),
        ("camera.keys.0.fov=3", "there is no entry 0 in this list; it is empty"),
        ("emitter.direction.0=3", "cannot be reached inside nothing"),
        ("lights.2.intensity=3", "there is no entry 2 in this list; it has 2, counted from 0"),
        ("lights.key.intensity=3", "no entry of this list has the name 'key'"),
        ("solids.hed.radius=3", "no entry of this list has the name 'hed'; did you mean 'head'?"),
        ("solids.head.size=[1, 1, 1]", "unknown key; the keys are kind, name, position"),
        ("rod.twist=1", "twist is not represented"),
        ("rod.young=1e308", "above 0 and of at most 1e+13 (Pa), not '1e308'"),
        ("panels.0.label=a", "single panels are changed in the preset itself"),
        ("extends=hair", "unknown key"),
        ("seed=*a", "aliases are refused"),
        ("seed=&a 3", "anchors are refused"),
        ("seed=!!int 3", "tags are refused"),
        ("camera={fov: 3, fov: 4}", "duplicate key 'fov'"),
        ("camera=[", "not valid YAML"),
        ("camera={positon: [1, 2, 3]}", "camera.positon: unknown key; did you mean 'position'?"),
        ("title=\x00", "holds a character that YAML does not allow"),
        ("seed", "must be PATH=VALUE, such as wind.strength=3"),
        ("=3", "must be PATH=VALUE"),
        ("", "must be PATH=VALUE"),
    ],
)
def test_overrides_that_are_refused(override: str, says: str) -> None:
    message = refused(BASE, override)
    assert len(message.splitlines()) == 1
    assert says in message
    if override.isprintable():
        assert message.startswith(f"--set {override}: ")


def test_faults_of_overrides_come_with_those_of_the_file_and_after() -> None:
    lines = refused("sed: 3\ntime: {fps: 0}\n", "wnd.strength=3", "time.frames=0").splitlines()
    assert [line.split(": ")[0] for line in lines] == [
        "p.yaml:1:1",
        "p.yaml:2:13",
        "--set wnd.strength=3",
        "--set time.frames=0",
    ]


def test_an_override_cannot_reach_into_what_is_malformed() -> None:
    lines = refused("camera: 3\n", "camera.fov=30").splitlines()
    assert lines == [
        "p.yaml:1:9: camera: must be a mapping of settings, not '3'",
        "--set camera.fov=30: 'fov' cannot be reached inside a single value",
    ]


# settings from Python


def test_settings_take_ready_values() -> None:
    settings = {
        "image.size": (320, 200),
        "emitter.strands": 12,
        "camera.position": [1, 2, 3.5],
        "title": "1e3",
        "detail": {"near": 2},
        "emitter.direction": None,
        "curves.mode": "off",
        "solids": [{"kind": "box", "visible": False}],
    }
    got = load("hair", rules=RULES, settings=settings)
    assert (got.image.size, got.emitter.strands, got.camera.position) == ((320, 200), 12, (1.0, 2.0, 3.5))
    assert (got.title, got.detail, got.solids[0].visible) == ("1e3", Detail(near=2.0), False)


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        ("image.size", (0, 3), "image.size: must be a size"),
        pytest.param("emitter.strands", 10**5000, "emitter.strands: must be a whole number", id="huge"),
        ("emitter.length", float("nan"), "emitter.length: must be a number above 0 (m), not '.nan'; it must be finite"),
        ("emitter.length", float("-inf"), "not '-.inf'; it must be finite"),
        ("emitter.length", True, "not 'true'"),
        ("emitter.length", "3", "not the text '3'"),
        ("emitter.lenght", 3, "emitter.lenght: unknown key; did you mean 'length'?"),
        ("seed", object(), "seed: a setting cannot be a object"),
    ],
)
def test_settings_that_are_refused(path: str, value: object, says: str) -> None:
    message = fails("hair", **{path: value})
    assert says in message
    assert message.startswith(path)
    assert len(message.splitlines()) == 1


# the hash


def test_the_hash_tells_scenes_apart() -> None:
    write("base.yaml", "seed: 1\n")
    write("p.yaml", "extends: base.yaml\n")

    def sha(*overrides: str, **settings: object) -> str:
        return load("p.yaml", rules=RULES, overrides=overrides, settings=settings).sha256

    first = sha()
    assert len(first) == 64
    assert first == sha()
    found = {first, sha("seed=2"), sha("seed=3"), sha("seed=2", "seed=3"), sha(title="a"), sha(title="b")}
    # where one override ends and the next begins makes a difference
    assert sha("title=aseed=2") != sha("title=a", "seed=2")
    write("base.yaml", "seed: 1 # changed\n")
    found.add(sha())
    write("p.yaml", "extends: base.yaml\n\n")
    found.add(sha())
    assert len(found) == 8


def test_locks_are_listed_from_wide_to_narrow() -> None:
    line = complaint("children:\n  clumps:\n    - {size: 0.01}\n    - {size: 0.02}\n")
    assert line.startswith("p.yaml:4:")
    assert "children.clumps.1.size" in line
    assert "from wide to narrow" in line
    assert [clump.size for clump in scene("children: {clumps: [{size: 0.02}, {size: 0.01}]}").children.clumps] == [
        0.02, 0.01
    ]  # fmt: skip


@pytest.mark.parametrize("quality", ["", "quality: default\n"])
def test_too_many_lights_or_panels_are_refused_at_once(quality: str) -> None:
    assert refused(f"{quality}lights:\n" + "- {kind: nope}\n" * 30_000).endswith(
        "lights: may have 256 entries at the most, not 30,000"
    )
    assert refused(f"{quality}panels:\n" + "- {label: a}\n" * 20_000).endswith(
        "panels: may have 100 entries at the most, not 20,000"
    )
