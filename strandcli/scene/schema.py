"""The preset's format as JSON Schema (draft 2020-12), for editors and other programs.

Whatever loads fits the schema. The schema cannot say what only a whole scene shows (`checks.py`), and leaves out the
limits of single precision.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from . import specs
from .dump import plain
from .fields import settings_of
from .model import Scene
from .rule_type import RuleType, doc_of, first_paragraph

Json = dict[str, Any]


def json_schema(rules: Mapping[str, RuleType]) -> Json:
    """The schema of presets that may use ``rules``."""
    return Writer(rules).document()


class Writer:
    """Writes each class once, under ``$defs``."""

    def __init__(self, rules: Mapping[str, RuleType]) -> None:
        self.rules = rules
        self.names: dict[type, str] = {}
        self.definitions: Json = {}

    def document(self) -> Json:
        """The whole schema."""
        scene = self.mapping(Scene)
        scene["properties"] = {
            "extends": {
                "type": ["string", "null"],
                "description": "preset that this one changes: a shipped name, or a path from this file",
            },
            **scene["properties"],
        }
        return {
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            "title": "strandcli preset",
            **scene,
            "$defs": self.definitions,
        }

    def mapping(self, cls: type) -> Json:
        """The schema of a mapping with the settings of ``cls``."""
        return {
            "description": first_paragraph(cls.__doc__),
            "type": "object",
            "properties": {key: self.setting(setting.spec) for key, setting in settings_of(cls).items()},
            "additionalProperties": False,
        }

    def reference(self, cls: type, name: str = "") -> Json:
        """A reference to the definition of ``cls``, which is written where it is not yet."""
        if cls not in self.names:
            name = name or cls.__name__
            while name in self.names.values():  # rules may have classes of the same name
                name += "_"
            self.names[cls] = name
            self.definitions[name] = self.mapping(cls)
        return {"$ref": f"#/$defs/{self.names[cls]}"}

    def setting(self, spec: specs.Spec) -> Json:
        """The schema of one setting: what it takes or null, which stands for its default, and what it means."""
        taken = spec.schema(self)
        if "type" in taken and "enum" not in taken and isinstance(taken["type"], str):
            taken["type"] = [taken["type"], "null"]
        else:
            taken = {"anyOf": [taken, {"type": "null"}]}
        unit = f" Unit: {spec.unit}." if spec.unit and spec.unit != "1" else ""
        described = f"{spec.doc[:1].upper()}{spec.doc[1:]}.{unit}" if spec.doc else unit.strip()
        if described:
            taken["description"] = described
        taken["default"] = plain(spec.default)
        return taken

    def kind(self, cls: type, tagged: bool) -> Json:
        """A reference to ``cls`` that may ask for its `kind`."""
        reference = self.reference(cls)
        return {**reference, "required": ["kind"]} if tagged else reference

    def rule_uses(self) -> Json:
        """A list of names and one-key mappings, or a mapping."""
        parameters = {}
        for name, rule in self.rules.items():
            about = self.reference(rule.Parameters, f"rule_{name}")
            parameters[name] = {"anyOf": [about, {"type": "null"}], "description": doc_of(rule)}
        one = {"type": "object", "properties": parameters, "additionalProperties": False}
        named = {"enum": list(self.rules)}
        listed = {"type": "array", "items": {"anyOf": [named, {**one, "minProperties": 1, "maxProperties": 1}]}}
        return {"anyOf": [listed, one]}

    def panel(self) -> Json:
        """One variant of the scene. Dotted paths as keys of `set` are beyond a schema."""
        inner = {
            key: self.setting(setting.spec)
            for key, setting in settings_of(Scene).items()
            if not isinstance(setting.spec, specs.PanelsSpec)
        }
        changes = "settings to change, nested or by dotted path such as `camera.fov`"
        properties = {
            "label": {"type": ["string", "number", "boolean", "null"], "description": "What stands below the picture."},
            "set": {"type": ["object", "null"], "properties": inner, "description": changes},
        }
        return {"type": "object", "properties": properties, "additionalProperties": False}
