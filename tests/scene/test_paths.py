"""Names and paths of presets: what is found, what is hidden, what is no preset, and how presets are described."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from scene_kit import RULES, fails, make_library, write
from strandcli.scene import describe_preset, load


@pytest.fixture(autouse=True)
def shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """`make_library`."""
    return make_library(tmp_path, monkeypatch)


def test_shipped_names_and_paths(shipped: Path) -> None:
    assert load("hair", rules=RULES).title == "shipped hair"
    assert load("figures/fig02", rules=RULES).source == str(shipped / "figures" / "fig02.yaml")
    write("hair.yaml", "title: mine\n")
    assert load("hair.yaml", rules=RULES).title == "mine"
    assert load(Path("hair.yaml").absolute(), rules=RULES).title == "mine"
    assert load("hair", rules=RULES).title == "shipped hair"


def test_a_bare_name_is_a_file_here_too() -> None:
    write("bob.yaml", "title: bob\n")
    write("deep/jim.yml", "title: jim\nextends: base\n")
    write("deep/base.yaml", "seed: 5\n")
    assert load("bob", rules=RULES).title == "bob"
    got = load("deep/jim", rules=RULES)
    assert (got.title, got.seed) == ("jim", 5)
    Path("bob").mkdir()
    assert load("bob", rules=RULES).title == "bob"
    write("base.yaml", "extends: hair\n")
    write("hair.yaml", "title: mine\n")
    assert load("base", rules=RULES).title == "shipped hair"


def test_a_preset_that_is_not_there() -> None:
    listing = "`strandcli presets list` shows what is shipped"
    assert fails("hiar") == f"no preset 'hiar'; did you mean 'hair'? {listing}"
    assert fails("fig02") == f"no preset 'fig02'; did you mean 'figures/fig02'? {listing}"
    assert fails("zzzzzz") == f"no preset 'zzzzzz'; {listing}"
    write("my/scene.yaml", "seed: 1")
    assert fails("my/scen.yaml") == "no preset 'my/scen.yaml': there is no such file; did you mean 'my/scene.yaml'?"
    assert fails("zzzzzz.yaml") == "no preset 'zzzzzz.yaml': there is no such file"


@pytest.mark.parametrize("name", ["", "a\0b.yaml", "x" * 5000, "../hair"])
def test_strange_names_are_no_presets(name: str) -> None:
    message = fails(name)
    assert len(message.splitlines()) == 1
    assert len(message) < 300


def test_what_is_no_file_is_no_preset() -> None:
    Path("d.yaml").mkdir()
    assert "'d.yaml' is a folder" in fails("d.yaml")
    os.mkfifo("pipe.yaml")
    Path("lost.yaml").symlink_to("nowhere.yaml")
    for name in ("pipe.yaml", "lost.yaml", os.devnull):
        assert f"'{name}' is a device, a pipe or a link to nowhere" in fails(name)


def test_a_preset_that_cannot_be_read(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    write("p.yaml", "seed: 1")
    monkeypatch.setattr(os, "open", refuse)
    assert fails("p.yaml") == "'p.yaml': no permission to read it"


def test_the_size_is_capped_before_all_is_read() -> None:
    with Path("big.yaml").open("wb") as file:
        file.truncate(1 << 40)  # a sparse terabyte
    assert fails("big.yaml") == "big.yaml:1:1: is larger than 1048576 bytes; is it a preset?"


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
