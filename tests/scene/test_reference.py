"""The reference of presets has every key of the schema with what it takes, its default and its meaning."""

from __future__ import annotations

from strandcli.scene import json_schema
from strandcli.scene.fields import settings_of
from strandcli.scene.model import Scene
from strandcli.scene.reference import HEAD, markdown, sections
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


def test_a_row_has_value_default_and_meaning() -> None:
    meaning = "Frames per second; 0: the strand file's, else 24."
    assert rows("`time`")["fps"] == ["`fps`", "number (1/s) 0 to 100,000", "`24.0`", meaning]
    assert rows("`camera`")["focus"][2] == "that of the target"
    assert rows("`lights[].shadow`")["model"][2] == "`minmax`"
    assert rows("rules: `wind`")["strength"][1] == "number (1/s²) ≥ 0"
    assert len(rows("A preset")["title"]) == len(HEAD)


def test_what_kinds_share_stands_once() -> None:
    assert rows("`lights[]`")["kind"][1] == "`directional`, `point`"
    assert "colour" in rows("`lights[]`")
    assert list(rows("`lights[]` of kind `point`")) == ["position", "intensity", "size"]
    assert list(rows("`solids[]` of kind `plane`")) == ["position", "fade"]


def test_tables_are_sound_markdown() -> None:
    for line in TEXT.splitlines():
        if line.startswith("|"):
            assert line.replace("\\|", "").count("|") == len(HEAD) + 1, line
