"""The preset's format as JSON Schema (draft 2020-12), for editors and other programs, and as Markdown for people:
every key with what it takes, its default and its meaning.

Whatever loads fits the schema. The schema cannot say what only a whole scene shows (`checks.py`), and leaves out the
limits of single precision.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from . import specs
from .dump import plain
from .fields import Setting, settings_of
from .model import Scene
from .rule_type import RuleType, doc_of, first_paragraph
from .specs import MOST_ITEMS, MOST_PANELS, NO_COLOUR

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


HEAD = ("Key", "Value", "Default", "Meaning")


class Section(NamedTuple):
    """The settings of one class or, where ``kinds`` has several, those that these share; and their path in a preset."""

    title: str
    model: type
    kinds: tuple[type, ...] = ()
    """Classes of all kinds that this one is a kind of, itself included."""
    shared: bool = False


def markdown(rules: Mapping[str, RuleType]) -> str:
    """Return the reference of presets that may use ``rules``: a heading and a table for each mapping, as Markdown."""
    parts = [
        "# Reference of presets",
        "Made by `strandcli schema --markdown`. Units are metres, seconds and degrees, y is up. A colour is linear, "
        '[r, g, b], or "#rrggbb" in sRGB. A key that is not written, or that is `null`, has its default.',
        "`extends` names a shipped preset, or the path of one from this file, which this preset changes. Each entry of "
        "`panels` has a `label` and, under `set`, the settings that it changes, nested or by dotted path.",
    ]
    for section in sections():
        doc = "Settings of every kind." if section.shared else paragraph(section.model.__doc__)
        parts += [f"## {section.title}", doc, table(rows_of(section))]
    for name, rule in sorted(rules.items(), key=lambda item: item[1].order):
        parts += [f"## rules: `{name}`", doc_of(rule), table(map(_row, settings_of(rule.Parameters).values()))]
    return "\n\n".join(part for part in parts if part) + "\n"


def sections() -> Iterator[Section]:
    """Every class of settings once, in the order in which a preset refers to them; rules are left out."""
    seen: set[tuple[type, bool]] = set()
    waiting = [Section("A preset", Scene)]
    while waiting:
        section = waiting.pop(0)
        if (section.model, section.shared) in seen:
            continue
        seen.add((section.model, section.shared))
        yield section
        prefix = "" if section.model is Scene else section.title.split("`")[1] + "."
        found = () if section.shared else settings_of(section.model).values()
        waiting[:0] = [inner for setting in found for inner in _inside(f"{prefix}{setting.key}", setting)]


def _inside(path: str, setting: Setting) -> list[Section]:
    """The sections that a setting refers to: of several kinds first what they share."""
    match setting.spec:
        case specs.ModelSpec():
            return [Section(f"`{path}`", setting.spec.model)]
        case specs.UnionSpec() | specs.ItemsSpec():
            entry = f"`{path}[]`" if isinstance(setting.spec, specs.ItemsSpec) else f"`{path}`"
            kinds = tuple(setting.spec.kinds.values())
            if len(kinds) == 1:
                return [Section(entry, kinds[0])]
            each = [Section(f"{entry} of kind `{kind}`", cls, kinds) for kind, cls in setting.spec.kinds.items()]
            return [Section(entry, kinds[0], kinds, shared=True), *each]
    return []


def rows_of(section: Section) -> list[tuple[str, ...]]:
    """The rows of a section's table; a kind's own are those that most kinds do not share."""
    if not section.kinds:
        return [_row(setting) for setting in settings_of(section.model).values()]
    tables = [{key: _row(setting) for key, setting in settings_of(cls).items()} for cls in section.kinds]
    options = ", ".join(table.pop("kind")[1] for table in tables)
    rows = [row for table in tables for row in table.values()]
    shared = {
        row[0]: row
        for row in rows
        if 2 * rows.count(row) > len(tables) and all(row[0].strip("`") in table for table in tables)
    }
    if section.shared:
        return [
            ("`kind`", options, _row(settings_of(section.model)["kind"])[2], "Which of the following."),
            *shared.values(),
        ]
    own = tables[section.kinds.index(section.model)].values()
    return [row for row in own if shared.get(row[0]) != row]


def table(rows: Iterable[tuple[str, ...]]) -> str:
    """The table of some rows, or a sentence where there are none."""
    lines = [f"| {' | '.join(cells)} |" for cells in (HEAD, *rows)]
    if len(lines) == 1:
        return "It has no settings."
    return "\n".join((lines[0], "|---" * len(HEAD) + "|", *lines[1:]))


def _row(setting: Setting) -> tuple[str, ...]:
    spec = setting.spec
    doc, _, absent = spec.doc.partition("; absent: ")
    options = spec.options if isinstance(spec, specs.ChoiceSpec) else ()
    first = doc[:1] if doc.startswith(options) else doc[:1].upper()
    meaning = f"{first}{doc[1:]}." if doc else ""
    cells = (_value(spec), absent or _default(spec), meaning)
    return (f"`{setting.key}`", *(cell.replace("|", "\\|") for cell in cells))


def _value(spec: specs.Spec) -> str:
    """What a setting takes: its type, unit and range, or its options."""
    if isinstance(spec, specs.ChoiceSpec):
        return _range(spec)
    none = f", or `{NO_COLOUR}`" if isinstance(spec, specs.ColourSpec) and spec.or_none else ""
    unit = f"({spec.unit})" if spec.unit and spec.unit != "1" else ""
    return " ".join(part for part in (spec.type_name + none, unit, _range(spec)) if part)


def _range(spec: specs.Spec) -> str:
    if isinstance(spec, specs.ChoiceSpec):
        return ", ".join(f"`{option}`" for option in spec.options)
    most = (
        spec.most if isinstance(spec, specs.ItemsSpec) else MOST_PANELS if isinstance(spec, specs.PanelsSpec) else None
    )
    if most is not None:
        return f"≤ {most:,} entries" if most < MOST_ITEMS else ""
    limits = spec.limits
    if limits.low is not None and limits.high is not None:
        return f"{_number(limits.low)} to {_number(limits.high)}"
    bounds = (("≥", limits.low), (">", limits.above), ("<", limits.below), ("≤", limits.high))
    words = ", ".join(f"{sign} {_number(limit)}" for sign, limit in bounds if limit is not None)
    nonzero = isinstance(spec, specs.VectorSpec) and spec.nonzero
    return words or ("not [0, 0, 0]" if nonzero else "")


def _number(limit: float) -> str:
    return f"{limit:,}" if isinstance(limit, int) else f"{limit:,.12g}"


def _default(spec: specs.Spec) -> str:
    """The value that stands where none is written."""
    if spec.default is None or isinstance(spec, specs.MapSpec):
        return "absent"
    if isinstance(spec, specs.FileSpec):
        return "required"
    if isinstance(spec, specs.ModelSpec):
        return "–"
    value = plain(spec.default)
    if isinstance(spec, specs.UnionSpec):
        return f"`kind: {value['kind']}`"
    if isinstance(spec, specs.ItemsSpec) and value:
        return "one of kind " + ", ".join(f"`{one['kind']}`" for one in value)
    return f"`{json.dumps(value, ensure_ascii=False)}`" if not isinstance(value, str) or not value else f"`{value}`"


def paragraph(doc: str | None) -> str:
    """A docstring as Markdown, its paragraphs on a line each."""
    parts = (doc or "").strip().split("\n\n")
    return "\n\n".join(" ".join(part.split()) for part in parts)
