"""Shipped presets: found by name, listed with what they show."""

from __future__ import annotations

from pathlib import Path

import pytest

from strandcli.errors import UsageError
from strandcli.scene import describe_preset, find, library, list_presets


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "figures").mkdir()
    for name in ("hair.yaml", "fur.yml", "figures/fig02.yaml", "figures/base.yaml", "README.md"):
        (tmp_path / name).write_text("seed: 1\n")
    monkeypatch.setattr(library, "folder", lambda: tmp_path)
    return tmp_path


def test_presets_are_listed_by_name_with_subfolders_last(folder: Path) -> None:
    assert [name for name, _ in list_presets()] == ["fur", "hair", "figures/base", "figures/fig02"]
    assert dict(list_presets())["fur"] == folder / "fur.yml"


def test_presets_are_found_by_name(folder: Path) -> None:
    assert find("figures/fig02") == folder / "figures" / "fig02.yaml"
    with pytest.raises(UsageError, match="no preset 'har'; did you mean 'hair'\\? `strandcli presets list`"):
        find("har")
    with pytest.raises(UsageError, match="did you mean 'figures/base'"):
        find("base")
    for name in ("../hair", "hair.yaml", "", "/", "figures"):
        with pytest.raises(UsageError, match="no preset"):
            find(name)


def test_without_a_folder_nothing_is_shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "folder", lambda: tmp_path / "none")
    assert list_presets() == []


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
