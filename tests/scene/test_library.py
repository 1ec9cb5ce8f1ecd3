"""Shipped presets: found by name, listed with what they show."""

from __future__ import annotations

from pathlib import Path

import pytest

from strandcli.scene import describe_preset


@pytest.mark.parametrize(
    ("text", "shows"),
    [
        ("# A comment\ntitle: Long hair\n", "Long hair"),
        ("emitter:\n  title: no\n", ""),
        ("# Faulty\ntitle: [\n", "Faulty"),
        ("", ""),
        ("\ufefftitle: marked\n", "marked"),
    ],
)
def test_a_preset_is_described_by_its_title_or_first_comment(tmp_path: Path, text: str, shows: str) -> None:
    path = tmp_path / "p.yaml"
    path.write_text(text, "utf-8")
    assert describe_preset(path) == shows


def test_what_cannot_be_read_has_no_description(tmp_path: Path) -> None:
    assert describe_preset(tmp_path / "none.yaml") == ""
    binary = tmp_path / "b.yaml"
    binary.write_bytes(bytes(range(256)))
    assert describe_preset(binary).isprintable()
