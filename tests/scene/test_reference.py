"""The reference of presets has every key of the schema with what it takes, its default and its meaning."""

from __future__ import annotations

from strandcli.scene import json_schema
from strandcli.scene.fields import settings_of
from strandcli.scene.model import Scene
from strandcli.scene.reference import markdown, sections
from strandcli.simulate.rules import registry

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
