"""The traps of YAML: each ends in a number, in text, or in a clear error with its place."""

from __future__ import annotations

from typing import Any
from unittest.mock import patch

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from scene_kit import complaint, complaints, error_of, scene
from strandcli.scene.nodes import ListNode, MapNode, Node
from strandcli.scene.yaml_source import DEEPEST, read


def fps(text: str) -> float:
    return scene(f"time: {{fps: {text}}}").time.fps


@pytest.mark.parametrize(
    ("written", "number"),
    [
        ("1e3", 1000.0),
        ("1.e1", 10.0),
        (".5", 0.5),
        ("+.5", 0.5),
    ],
)
def test_numbers_that_are_numbers(written: str, number: float) -> None:
    assert fps(written) == number


@pytest.mark.parametrize(
    ("written", "says"),
    [
        *((text, "YAML readers disagree about") for text in ("12:30", "1_000", "010", "0x18", "0,5")),
        (".nan", "must be finite"),
        ("-.INF", "must be finite"),
        ("1e999", "too large"),
        ("9" * 5000, "not '999"),
        ("no", "must be a number of at least 0"),
        ("true", "must be a number of at least 0"),
        ('"24"', "take the quotes away"),
        ("24 fps", "(1/s), not '24 fps'"),
        ("2012-01-01", "must be a number"),
        ("{a: 24}", "not a mapping"),
        ("", "not nothing"),
    ],
)
def test_numbers_that_are_none(written: str, says: str) -> None:
    line = complaint(f"time:\n  fps: {written}\n")
    assert line.startswith("p.yaml:2:")
    assert "time.fps: must be a number" in line
    assert says in line
    assert len(line) < 300


@pytest.mark.parametrize("written", ["10.5", ".nan", "true", "010"])
def test_whole_numbers_that_are_none(written: str) -> None:
    assert "emitter.strands: must be a whole number" in complaint(f"emitter: {{strands: {written}}}")


@pytest.mark.parametrize(("word", "meant"), [("no", "false"), ("Off", "false"), ("yes", "true"), ("ON", "true")])
def test_truth_values_of_one_yaml_only_are_refused(word: str, meant: str) -> None:
    assert complaint(f"detail: {{widen: {word}}}").endswith(f"YAML readers disagree about; write {meant}")


@pytest.mark.parametrize("word", ["1", '"true"', "maybe"])
def test_truth_values_are_nothing_else(word: str) -> None:
    assert "detail.widen: must be true or false" in complaint(f"detail: {{widen: {word}}}")


def test_duplicate_keys_are_faults_with_the_first_line() -> None:
    text = "time:\n  fps: 10\n  frames: 3\n  fps: 20\nseed: 1\nseed: 2\n"
    assert complaints(text) == [
        "p.yaml:4:3: duplicate key 'fps', first given on line 2",
        "p.yaml:6:1: duplicate key 'seed', first given on line 5",
    ]


def test_anchors_and_aliases_are_refused_each_where_it_stands() -> None:
    text = "camera: {position: &eye [0, 0, 5]}\nlights:\n- {kind: point, position: *eye}\n"
    first, second = complaints(text)
    assert first.startswith("p.yaml:1:20: `&eye`: anchors are refused")
    assert second.startswith("p.yaml:3:27: `*eye`: aliases are refused")


def test_merge_keys_are_refused() -> None:
    assert "merge keys are refused; use `extends`" in complaint("<<: {title: a}\n")


@pytest.mark.parametrize("value", ["!!float 3", "!!python/object:os.system x"])
def test_tags_are_refused(value: str) -> None:
    assert any("tags are refused" in line for line in complaints(f"seed: {value}"))


def test_depth_is_capped_before_it_hurts() -> None:
    deep = "a: " + "[" * 100_000
    assert complaint(deep) == f"p.yaml:1:{3 + DEEPEST}: is nested more than {DEEPEST} deep"
    assert f"more than {DEEPEST} deep" in complaint("- " * 200_000)
    assert f"more than {DEEPEST} deep" in complaint("? " * 200_000)
    assert f"more than {DEEPEST} deep" in complaint("a: " + "{a: " * 200)


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "p.yaml:1:1: is empty"),
        (b"---\n", "p.yaml:1:1: is empty"),
        (b"- title\n", "p.yaml:1:1: must be a mapping of settings"),
        (b"title: a\n---\ntitle: b\n", "p.yaml:2:1: has more than one document"),
        (b"title: caf\xe9\n", "p.yaml:1:11: is not UTF-8 text (byte 0xe9)"),
        ("title: ä\nseed: \u00e4".encode() + b"\xff", "p.yaml:2:8: is not UTF-8 text (byte 0xff)"),
        ("title: a".encode("utf-16"), "p.yaml:1:1: is UTF-16 text; save it as UTF-8"),
        (b"\x89PNG\r\n\x1a\n\0\0", "is not UTF-8 text"),
        (b"title: a\n\0\0\0", "p.yaml:2:1: has a character that YAML does not allow: '\\x00'"),
        (b"time:\n\tfps: 3\n", "p.yaml:2:1: not valid YAML: a tab cannot indent; use spaces"),
        (b"title: a: b\n", "p.yaml:1:9: not valid YAML: a `: ` where no mapping can begin"),
        (b"title: %a\n", "p.yaml:1:8: not valid YAML: found character '%' that cannot start any token; quote"),
        (b"title: [a\n", "not valid YAML: expected ',' or ']'"),
        (b'title: "\\UFFFFFFFF"\n', "has a number or an escape"),
        (b'title: "\\ud800"\n', "half a surrogate pair"),
        (b"[a]: 1\n", "p.yaml:1:1: a key must be a single word"),
    ],
)
def test_what_is_no_preset_is_told_with_its_place(data: bytes, says: str) -> None:
    error = error_of(lambda: read(data, "p.yaml"))
    lines = str(error).splitlines() if error else [str(fault) for fault in read(data, "p.yaml")[1]]
    assert len(lines) == 1
    assert says in lines[0]


def test_a_byte_order_mark_is_no_part_of_the_first_key() -> None:
    root, found = read(b"\xef\xbb\xbftitle: a\n", "p.yaml")
    assert (list(root.entries), found) == (["title"], [])


def test_keys_that_yaml_would_take_for_truth_values_are_words() -> None:
    assert complaint("on: 3").startswith("p.yaml:1:1: on: unknown key")
    assert complaint("null: 3").startswith("p.yaml:1:1: null: unknown key")


def test_an_unquoted_hex_colour_is_a_comment_and_told_so() -> None:
    line = complaint("material:\n  colour: #ff0000\n")
    assert "material.colour" in line
    assert "without quotes a # begins a comment" in line


def test_a_message_stays_one_short_line_whatever_was_written() -> None:
    for line in complaints('time: {fps: "a\\nb\\e[31m' + "x" * 1000 + '", "\\r\\n": 3}'):
        assert line.isprintable()
        assert len(line) < 250


def leaves(node: Node) -> Any:
    """A tree as plain values: texts with whether they are plain, and all marks."""
    if isinstance(node, MapNode):
        return {key: (entry.mark, leaves(entry.node)) for key, entry in node.entries.items()}
    if isinstance(node, ListNode):
        return [node.mark, *(leaves(item) for item in node.items)]
    return node.text, node.plain, node.mark


@given(st.lists(st.dictionaries(st.text("abc:#'\" é-", max_size=5), st.integers() | st.text(max_size=8)), max_size=6))
def test_both_parsers_find_the_same_tree(value: list[Any]) -> None:
    data = yaml.safe_dump({"key": value}, allow_unicode=True).encode()
    with patch.object(yaml, "__with_libyaml__", False):
        tree, faults = read(data, "f.yaml")
    same, none = read(data, "f.yaml")
    assert leaves(tree) == leaves(same)
    assert faults == none
