"""Shipped presets: each is valid and described, and draws the picture that was once looked at and found good."""

from __future__ import annotations

from pathlib import Path

import pytest

import strandcli
from cli_runs import Runner
from strandcli.scene import list_presets
from strandcli.study import golden
from strandcli.study.golden import Entry, read_entries

NAMES = [name for name, _ in list_presets()]
FIGURES = [f"figures/fig{number:02d}" for number in range(2, 15)]
GOLDEN = Path(__file__).parents[1] / "golden"
ENTRIES = read_entries(GOLDEN)


def test_everything_that_is_promised_is_shipped(run: Runner) -> None:
    assert {"hair", "fur", "grass", "ponytail", "minimal", *FIGURES} <= set(NAMES)
    result = run.fine("presets", "list")
    for name in NAMES:
        title = strandcli.load(name).title
        assert any(line.split(maxsplit=1) == [name, title] for line in result.out.splitlines()), name


@pytest.mark.parametrize("name", NAMES)
def test_a_preset_is_valid_and_tells_a_newcomer_what_it_is(name: str) -> None:
    scene = strandcli.load(name)
    assert len(scene.title) > 10
    text = dict(list_presets())[name].read_text("utf-8")
    assert text.startswith("# "), "the first line says what there is to see"
    assert text.count("#") >= 3
    if name in FIGURES:
        assert scene.title.startswith(f"Figure {int(name[-2:])}: ")
        for one in scene.panels or (scene,):
            assert one.emitter.strands <= 10_000
            assert one.image.size[0] * one.image.size[1] <= 400 * 300
        assert all(one.label for one in scene.panels)


def test_every_preset_has_a_golden_image() -> None:
    assert {entry.preset for entry in ENTRIES} == set(NAMES)
    assert all(entry.size is not None and entry.size[0] * entry.size[1] <= 160 * 120 for entry in ENTRIES)


@pytest.mark.parametrize("entry", ENTRIES, ids=[entry.name for entry in ENTRIES])
def test_it_is_the_picture_on_record(entry: Entry, tmp_path: Path) -> None:
    """To the bit on machines of a class that is recorded, on others within the tolerance of `study.golden`."""
    found = golden.check(GOLDEN, entry, tmp_path, golden.draw)
    assert found.matches, found.words
