"""The reference of presets has every key of the schema with its type, range, unit, default and meaning."""

from __future__ import annotations

from strandcli.scene import json_schema
from strandcli.scene.reference import HEAD, TYPES, markdown, sections
from strandcli.simulate.rules import registry

TEXT = markdown(registry())


def rows(title: str) -> dict[str, list[str]]:
    """The table under a heading: the cells of each row by its key."""
    part = TEXT.split(f"\n## {title}\n")[1].split("\n## ")[0]
    cells = [line.strip("| ").split(" | ") for line in part.splitlines() if line.startswith("| `")]
    return {row[0].strip("`"): row for row in cells}


def test_each_key_of_the_schema_stands_in_a_table() -> None:
    definitions = json_schema(registry())["$defs"]
    counted = sorted(len(one["properties"]) for name, one in definitions.items())
    tables = [part.count("\n| `") for part in TEXT.split("\n## ")[2:]]
    assert sorted(tables) == counted
    titles = [section.title for section in sections()]
    assert len(titles) == len(set(titles))


def test_a_row_has_type_range_unit_default_and_meaning() -> None:
    fps = rows("`time`")["fps"]
    meaning = "Frames a second; 0: those that the file of strands says, else 24."
    assert fps == ["`fps`", "number", "≥ 0, ≤ 100,000", "1/s", "`24.0`", meaning]
    assert rows("`camera`")["focus"][4] == "absent"
    assert rows("`lights[]` of kind `directional`")["kind"][2] == "`directional`"
    assert rows("`lights[].shadow`")["model"][4] == "`minmax`"
    assert rows("rules: `wind`")["strength"][1] == "number"
    assert len(rows("A preset")["title"]) == len(HEAD)


def test_tables_are_sound_markdown() -> None:
    for line in TEXT.splitlines():
        if line.startswith("|"):
            assert line.replace("\\|", "").count("|") == len(HEAD) + 1, line
    assert all(TYPES.values())
