"""The reference of presets as Markdown: every key with its type, range, unit, default and meaning."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from .dump import plain
from .fields import Setting, settings_of
from .model import Scene
from .rule_type import RuleType, doc_of
from .specs import (
    MOST_PANELS,
    NO_COLOUR,
    BooleanSpec,
    ChoiceSpec,
    ColourSpec,
    FileSpec,
    IntegerSpec,
    ItemsSpec,
    MapSpec,
    ModelSpec,
    NamesSpec,
    NumberSpec,
    PanelsSpec,
    ParametersSpec,
    RulesSpec,
    SizeSpec,
    Spec,
    TextSpec,
    UnionSpec,
    VectorSpec,
    WindowSpec,
)

HEAD = ("Key", "Type", "Range", "Unit", "Default", "Meaning")

TYPES: Mapping[type[Spec], str] = {
    NumberSpec: "number",
    IntegerSpec: "integer",
    VectorSpec: "[x, y, z]",
    ColourSpec: '[r, g, b] or "#rrggbb"',
    SizeSpec: '[w, h] or "800x600"',
    WindowSpec: '[x, y, w, h] or "400x300+100+50"',
    ChoiceSpec: "word",
    BooleanSpec: "true or false",
    FileSpec: "path of a file",
    MapSpec: "name, or path of a picture",
    TextSpec: "text",
    NamesSpec: "list of names",
    ModelSpec: "mapping",
    UnionSpec: "mapping",
    ItemsSpec: "list of mappings",
    ParametersSpec: "mapping",
    RulesSpec: "list or mapping of rules",
    PanelsSpec: "list of panels",
}


class Section(NamedTuple):
    """The settings of one class, and the path at which a preset holds them."""

    title: str
    model: type


def markdown(rules: Mapping[str, RuleType]) -> str:
    """Return the reference of presets that may use ``rules``: a heading and a table for each mapping, as Markdown."""
    parts = [
        "# Reference of presets",
        "This page is made by `strandcli schema --markdown`. Units are metres, seconds and degrees, y is up. A key "
        "that is not written, or that is `null`, has its default.",
        "A preset may begin with `extends`, the shipped name of another preset or a path from its own file: it then "
        "changes that preset. Each entry of `panels` has a `label` and, under `set`, the settings that it changes, "
        "nested or by dotted path such as `camera.fov`.",
    ]
    for section in sections():
        parts += [f"## {section.title}", paragraph(section.model.__doc__), table(settings_of(section.model).values())]
    for name, rule in sorted(rules.items(), key=lambda item: item[1].order):
        parts += [f"## rules: `{name}`", doc_of(rule), table(settings_of(rule.Parameters).values())]
    return "\n\n".join(part for part in parts if part) + "\n"


def sections() -> Iterator[Section]:
    """Every class of settings once, in the order in which a preset refers to them; rules are left out."""
    seen: set[type] = set()
    waiting = [Section("A preset", Scene)]
    while waiting:
        section = waiting.pop(0)
        if section.model in seen:
            continue
        seen.add(section.model)
        yield section
        prefix = "" if section.model is Scene else section.title.split("`")[1] + "."
        found = settings_of(section.model).values()
        waiting[:0] = [inner for setting in found for inner in _inside(f"{prefix}{setting.key}", setting)]


def _inside(path: str, setting: Setting) -> list[Section]:
    """The sections that a setting refers to."""
    match setting.spec:
        case ModelSpec():
            return [Section(f"`{path}`", setting.spec.model)]
        case UnionSpec() | ItemsSpec():
            entry = f"{path}[]" if isinstance(setting.spec, ItemsSpec) else path
            kinds = setting.spec.kinds.items()
            return [Section(f"`{entry}`" + (f" of kind `{kind}`" if kind else ""), cls) for kind, cls in kinds]
    return []


def table(settings: Any) -> str:
    """The table of some settings, or a sentence where there are none."""
    rows = [_row(setting) for setting in settings]
    if not rows:
        return "It has no settings."
    lines = [HEAD, tuple("---" for _ in HEAD), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def _row(setting: Setting) -> tuple[str, ...]:
    spec = setting.spec
    unit = "" if spec.unit == "1" else spec.unit
    options = spec.options if isinstance(spec, ChoiceSpec) else ()
    first = spec.doc[:1] if spec.doc.startswith(options) else spec.doc[:1].upper()
    meaning = f"{first}{spec.doc[1:]}." if spec.doc else ""
    none = f", or `{NO_COLOUR}`" if isinstance(spec, ColourSpec) and spec.or_none else ""
    cells = (TYPES[type(spec)] + none, _range(spec), unit, _default(spec), meaning)
    return (f"`{setting.key}`", *(cell.replace("|", "\\|") for cell in cells))


def _range(spec: Spec) -> str:
    if isinstance(spec, ChoiceSpec):
        return ", ".join(f"`{option}`" for option in spec.options)
    most = spec.most if isinstance(spec, ItemsSpec) else MOST_PANELS if isinstance(spec, PanelsSpec) else None
    if most is not None:
        return f"≤ {most:,} entries"
    limits = spec.limits
    bounds = (("≥", limits.low), (">", limits.above), ("<", limits.below), ("≤", limits.high))
    words = ", ".join(f"{sign} {_number(limit)}" for sign, limit in bounds if limit is not None)
    nonzero = isinstance(spec, VectorSpec) and spec.nonzero
    return words or ("not [0, 0, 0]" if nonzero else "")


def _number(limit: float) -> str:
    return f"{limit:,}" if isinstance(limit, int) else f"{limit:,.12g}"


def _default(spec: Spec) -> str:
    """The value that stands where none is written."""
    if isinstance(spec, FileSpec) and spec.default is not None:
        return "must be given"
    if spec.default is None or (isinstance(spec, MapSpec) and not spec.default):
        return "absent"
    if isinstance(spec, ModelSpec):
        return "the defaults of its keys"
    value = plain(spec.default)
    if isinstance(spec, UnionSpec):
        return f"`kind: {value['kind']}`"
    if isinstance(spec, ItemsSpec) and value:
        return "one of kind " + ", ".join(f"`{one['kind']}`" for one in value)
    return f"`{json.dumps(value, ensure_ascii=False)}`" if not isinstance(value, str) or not value else f"`{value}`"


def paragraph(doc: str | None) -> str:
    """A docstring as Markdown, its paragraphs on a line each."""
    parts = (doc or "").strip().split("\n\n")
    return "\n\n".join(" ".join(part.split()) for part in parts)
