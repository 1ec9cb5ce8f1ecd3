"""The JSON Schema agrees with the validator: what loads fits it, and it refuses what the validator refuses; the
reference of presets has every key of it."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from scene_kit import RULES, error_of, scene
from scene_strategies import single_scenes
from strandcli.scene import dump, json_schema, loads, to_dict
from strandcli.scene.fields import settings_of
from strandcli.scene.model import LIGHTS, SOLIDS, Scene
from strandcli.scene.schema import markdown, sections
from strandcli.scene.specs import Spec
from strandcli.simulate.rules import registry

SCHEMA = json_schema(RULES)

NOTES = {"title", "description", "default", "$schema", "$defs"}
TYPES: dict[str, tuple[type, ...]] = {
    "object": (dict,),
    "array": (list,),
    "string": (str,),
    "number": (int, float),
    "boolean": (bool,),
    "null": (type(None),),
}


def is_type(value: Any, name: str) -> bool:
    if name == "integer":
        return is_type(value, "number") and float(value).is_integer()
    return isinstance(value, TYPES[name]) and (name == "boolean" or not isinstance(value, bool))


def fits(value: Any, schema: dict[str, Any]) -> bool:
    """A small validator by the words of draft 2020-12; a keyword that it does not know is an error of the schema."""
    for word, rule in schema.items():
        match word:
            case _ if word in NOTES:
                good = True
            case "$ref":
                good = fits(value, SCHEMA["$defs"][rule.removeprefix("#/$defs/")])
            case "anyOf":
                good = any(fits(value, option) for option in rule)
            case "not":
                good = not fits(value, rule)
            case "type":
                good = any(is_type(value, name) for name in ([rule] if isinstance(rule, str) else rule))
            case "enum":
                good = value in rule
            case "const":
                good = value == rule
            case "minimum" | "maximum" | "exclusiveMinimum" | "exclusiveMaximum":
                good = (
                    not is_type(value, "number")
                    or {
                        "minimum": value >= rule,
                        "maximum": value <= rule,
                        "exclusiveMinimum": value > rule,
                        "exclusiveMaximum": value < rule,
                    }[word]
                )
            case "pattern":
                good = not isinstance(value, str) or re.search(rule, value) is not None
            case "items":
                good = not isinstance(value, list) or all(fits(item, rule) for item in value)
            case "minItems" | "maxItems":
                good = not isinstance(value, list) or (len(value) >= rule if word[1] == "i" else len(value) <= rule)
            case "minProperties" | "maxProperties":
                good = not isinstance(value, dict) or (len(value) >= rule if word[1] == "i" else len(value) <= rule)
            case "required":
                good = not isinstance(value, dict) or all(key in value for key in rule)
            case "properties":
                good = not isinstance(value, dict) or all(fits(value[key], rule[key]) for key in rule if key in value)
            case "additionalProperties":
                good = not isinstance(value, dict) or rule is not False or set(value) <= set(schema["properties"])
            case _:
                raise AssertionError(f"{word} is no keyword that this schema should need")
        if not good:
            return False
    return True


def parts(schema: Any) -> list[dict[str, Any]]:
    """All schemas inside a schema, with itself."""
    found = []
    if isinstance(schema, dict):
        found.append(schema)
        for key, value in schema.items():
            if key not in ("default", "const", "enum"):
                found.extend(parts(value))
    elif isinstance(schema, list):
        for value in schema:
            found.extend(parts(value))
    return found


def test_every_reference_leads_somewhere_and_everything_is_used() -> None:
    used = {part["$ref"] for part in parts(SCHEMA) if "$ref" in part}
    assert used == {f"#/$defs/{name}" for name in SCHEMA["$defs"]}


def test_every_default_fits_its_own_schema() -> None:
    described = [part for part in parts(SCHEMA) if "default" in part]
    assert len(described) > 80
    for part in described:
        assert fits(part["default"], part), part


def test_every_setting_is_there_described_with_unit_range_and_options() -> None:
    assert list(SCHEMA["properties"]) == ["extends", *settings_of(Scene)]
    emitter = SCHEMA["$defs"]["Emitter"]["properties"]
    assert emitter["length"]["description"] == "Mean strand length from root to tip. Unit: m."
    assert emitter["length"]["exclusiveMinimum"] == 0
    assert (emitter["strands"]["minimum"], emitter["strands"]["maximum"]) == (1, 100_000_000)
    assert SCHEMA["$defs"]["Curves"]["properties"]["mode"]["anyOf"][0] == {
        "enum": ["adaptive", "fixed", "off", "thinned"]
    }
    assert "Blows." in json.dumps(SCHEMA["properties"]["rules"])
    for name, part in SCHEMA["$defs"].items():
        assert part["additionalProperties"] is False
        assert part["description"]
        for key, setting in part["properties"].items():
            assert key == "kind" or setting.get("description"), (name, key)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much])
@given(single_scenes())
def test_every_valid_scene_fits(made: Scene) -> None:
    assert fits(to_dict(made), SCHEMA)
    assert fits(yaml.safe_load(dump(made)), SCHEMA)


@pytest.mark.parametrize(
    "text",
    [
        "rules: [wind, gravity: {acceleration: [0, 0, 0]}, wind: {}]",
        "rules: {wind: , gravity: null}",
        "emitter: {shape: {cap: 3}}",
        "emitter: {shape: {kind: plane, width: 3}}",
        "image: {size: 800x600}",
        "image: {background: '#a0b1c2'}",
        "camera: null",
        "panels: [{label: 3, set: {wind.strength: 3}}, {}]\nrules: [wind]",
        "panels: [{set: {camera: {fov: 3}}}]",
        "time: {frames: 10.0}",
        "solids: [{kind: box, name: a}]\nrules: [collision: {with: a}]",
    ],
)
def test_what_loads_fits(text: str) -> None:
    scene(text)
    assert fits(yaml.safe_load(text), SCHEMA)


BAD: list[tuple[str, Any]] = [
    ("sed", 3),
    ("seed", -1),
    ("solver", "thesys"),
    ("time", {"fsp": 1}),
    ("camera", {"up": [0, 0, 0]}),
    ("camera", {"fov": 180}),
    ("ambient", [-1, 0, 0]),
    ("image", {"size": [0, 1]}),
    ("curves", {"mode": "fix"}),
    ("detail", {"widen": 1}),
    ("solids", [{"kind": "cube"}]),
    ("solids", [{"kind": "sphere", "size": [1, 1, 1]}]),
    ("emitter", {"shape": {"kind": "disc", "cap": 3}}),
    ("emitter", {"shape": {"width": 3}}),
    ("rules", ["wnd"]),
    ("rules", [{"wind": {"strenght": 3}}]),
    ("rules", [{"wind": {}, "gravity": {}}]),
    ("rules", {"wnd": {}}),
    ("panels", [{"lable": "a"}]),
]  # fmt: skip


@pytest.mark.parametrize(("key", "value"), BAD)
def test_what_the_schema_refuses_does_not_load_either(key: str, value: Any) -> None:
    assert not fits({key: value}, SCHEMA)
    assert error_of(lambda: loads(yaml.safe_dump({key: value}), rules=RULES)) is not None


settings_paths = st.sampled_from(
    [(name, key) for name, setting in settings_of(Scene).items() if isinstance(setting.spec, Spec)
     for key in (settings_of(setting.spec.model) if hasattr(setting.spec, "model") else ())]
)  # fmt: skip
anything = st.one_of(
    st.integers(-10, 300), st.floats(-2, 200), st.booleans(), st.sampled_from(["off", "#ffffff", "4x4", "x", "box"]),
    st.lists(st.integers(-1, 3) | st.floats(-1, 3), min_size=2, max_size=4),
)  # fmt: skip


@settings(max_examples=100, deadline=None)
@given(settings_paths, anything)
def test_whatever_loads_fits(path: tuple[str, str], value: Any) -> None:
    tree = {path[0]: {path[1]: value}}
    if error_of(lambda: loads(yaml.safe_dump(tree), rules=RULES)) is None:
        assert fits(tree, SCHEMA)


def test_every_kind_is_told_apart() -> None:
    for key, kinds in (("solids", SOLIDS), ("lights", LIGHTS)):
        for kind in kinds:
            assert fits({key: [{"kind": kind}]}, SCHEMA)
            needed = f", file: {Path(__file__).parents[2] / 'presets/meshes/head.ply'}" if kind == "mesh" else ""
            assert scene(f"{key}: [{{kind: {kind}{needed}}}]")


def test_rules_with_parameter_classes_of_one_name_do_not_mix() -> None:
    from dataclasses import make_dataclass

    from scene_kit import FakeRule
    from strandcli.scene.fields import items, number

    def rule(name: str, key: str) -> FakeRule:
        inner = make_dataclass("Key", [(key, float, number(0.0, doc="a"))], frozen=True)
        return FakeRule(name, make_dataclass("Parameters", [("keys", tuple, items(inner, doc="b"))], frozen=True), 1.0)

    schema = json_schema({"a": rule("a", "left"), "b": rule("b", "right")})
    keys = [part["properties"] for name, part in schema["$defs"].items() if name.startswith("Key")]
    assert [list(properties) for properties in keys] == [["left"], ["right"]]


TEXT = markdown(registry())


def rows(title: str) -> dict[str, list[str]]:
    """The table under a heading: the cells of each row by its key."""
    part = TEXT.split(f"\n## {title}\n")[1].split("\n## ")[0]
    cells = [line.strip("| ").split(" | ") for line in part.splitlines() if line.startswith("| `")]
    return {row[0].strip("`"): row for row in cells}


def test_each_key_of_the_schema_stands_in_a_table() -> None:
    """What most kinds of an entry share stands once, in the table before theirs."""
    keys = set(settings_of(Scene))
    for section in sections():
        if not section.shared:
            own = set(rows(section.title))
            shared = set(rows(section.title.split(" of kind ")[0])) if section.kinds else set()
            assert own | shared == set(settings_of(section.model))
            keys |= own | shared
    for rule in registry().values():
        keys |= set(rows(f"rules: `{rule.name}`"))
    definitions = json_schema(registry())["$defs"].values()
    assert keys == {*settings_of(Scene), *(key for one in definitions for key in one["properties"])}
    titles = [section.title for section in sections()]
    assert len(titles) == len(set(titles))
