"""`--set`: paths that reach everything, and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from scene_kit import changed, make_library, refused
from strandcli.scene import SceneError
from strandcli.scene.model import Detail, DiscShape, PointLight


@pytest.fixture(autouse=True)
def shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """`make_library`."""
    return make_library(tmp_path, monkeypatch)


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


def test_null_takes_an_entry_out_of_a_list() -> None:
    got = changed(BASE, "solids.head=null", "lights.0=null", "solids.0.size=[1, 2, 3]")
    assert [solid.name for solid in got.solids] == ["1x"]
    assert [light.kind for light in got.lights] == ["directional"]
    assert changed(BASE, "solids.0=null", "solids.0=null").solids == ()
    keys = "camera: {keys: [{time: 0, position: [1, 2, 3]}, {time: 1}, {time: 2}]}"
    assert [key.time for key in changed(keys, "camera.keys.1=null").camera.keys] == [0.0, 2.0]


def test_an_entry_of_another_kind_takes_the_place_and_the_name() -> None:
    head = "{kind: sphere, name: head, position: [1, 2, 3], radius: 2}"
    base = f"{{solids: [{head}], rules: {{collision: {{with: [head]}}}}}}"
    (solid,) = changed(base, "solids.head={radius: 3}").solids
    assert (solid.position, solid.radius) == ((1.0, 2.0, 3.0), 3.0)  # type: ignore[union-attr]
    (solid,) = changed(base, "solids.head={kind: box}").solids
    assert (solid.kind, solid.name, solid.position) == ("box", "head", (0.0, 0.0, 0.0))
    (solid,) = changed(base, "solids.head.kind=box").solids
    assert (solid.kind, solid.name, solid.position) == ("box", "head", (1.0, 2.0, 3.0))
    message = refused(base, "solids.head=null")
    assert "'head'" in message


@pytest.mark.parametrize("rules", ["[gravity, {wind: {strength: 3}}]", "{gravity: {}, wind: {strength: 3}}"])
def test_a_rule_that_is_not_listed_is_added_with_its_parameters(rules: str) -> None:
    got = changed(f"rules: {rules}", "rules.elasticity={}", "wind[2]={strength: 7}")
    assert [use.name for use in got.rules] == ["gravity", "wind", "elasticity", "wind"]
    assert [use.parameters.strength for use in got.rules if use.name == "wind"] == [3.0, 7.0]


@pytest.mark.parametrize(
    ("override", "says"),
    [
        ("wind.strenght=3", "unknown key; did you mean 'strength'?"),
        ("sed=3", "unknown key; did you mean 'seed'?"),
        ("strands=5", "unknown key; did you mean 'emitter.strands'?"),
        ("wnd.strength=3", "unknown key; did you mean 'wind'?"),
        ("motion_blur=0.5", "unknown key; did you mean camera.shutter=0.5?"),
        ("image.resolution=800x600", "unknown key; did you mean image.size=[800, 600]?"),
        ("rules.wind=off", "not 'off'; null takes the rule out: rules.wind=null"),
        ("wind[2]=off", "not 'off'; null takes the rule out: rules.wind[2]=null"),
        ("rules.wnd.strength=3", "unknown rule 'wnd'; did you mean 'wind'?"),
        ("collision.segments=true", "the preset does not list the rule 'collision'; its rules are gravity, wind, wind"),
        ("wind[3].strength=3", "the preset does not list the rule 'wind' 3 times; its rules are gravity, wind, wind"),
        ("time.fps=0", "0 is as a file of strands says; there is no emitter.groom: write a number"),
        ("time.fps=no", "not 'no'"),
        ("time.fps=", "not nothing"),
        ("time.fps.x=3", "there is nothing inside this setting"),
        ("camera.position.x=3", "no entry of this list has the name 'x'; none has a name; count them from 0"),
        ("camera.position.3=3", "there is no entry 3 in this list; it has 3, counted from 0"),
        ("solids.hed.radius=3", "no entry of this list has the name 'hed'; did you mean 'head'?"),
        ("solids.head.size=[1, 1, 1]", "unknown key; the keys are kind, name, position"),
        ("rod.twist=1", "how much strands resist it is torsion"),
        ("panels.0.label=a", "single panels are changed in the preset itself"),
        ("solids.2=null", "there is no entry 2 in this list"),
        ("seed=*a", "aliases are refused"),
        ("camera={fov: 3, fov: 4}", "duplicate key 'fov'"),
        ("camera={positon: [1, 2, 3]}", "camera.positon: unknown key; did you mean 'position'?"),
        ("title=\x00", "has a character that YAML does not allow"),
        ("seed", "must be PATH=VALUE, such as wind.strength=3"),
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


def test_a_fault_names_what_the_caller_gave(tmp_path: Path) -> None:
    import strandcli

    path = tmp_path / "p.yaml"
    path.write_text("title: a preset\n")
    for given, said in (({}, "overrides"), ({"option": "--set"}, "--set")):
        with pytest.raises(SceneError) as raised:
            strandcli.load(str(path), ["time.frames=0"], **given)  # type: ignore[arg-type]
        assert str(raised.value).startswith(f"{said} time.frames=0: ")
