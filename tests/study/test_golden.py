"""Golden images: one changed pixel is caught, on this class of machine and, in the golden picture, on every other."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from strandcli.errors import SimulationError, UsageError
from strandcli.output import png
from strandcli.output.compare import write_image
from strandcli.study import golden
from strandcli.study.golden import Entry

ENTRY = Entry("hair", "hair", ("wind.strength=3",), 2, (40, 30))


def draw(entry: Entry, directory: Path) -> np.ndarray:
    return np.random.default_rng(len(entry.name) + entry.frame).integers(0, 256, (30, 40, 3), dtype=np.uint8)


def changed(pixels: int, by: int) -> golden.Draw:
    """A drawer that gets ``pixels`` pixels wrong by ``by``."""

    def wrong(entry: Entry, directory: Path) -> np.ndarray:
        image = draw(entry, directory)
        flat = image.reshape(-1, 3)
        flat[:pixels, 1] = np.where(flat[:pixels, 1] < 128, flat[:pixels, 1] + by, flat[:pixels, 1] - by)
        return image

    return wrong


@pytest.fixture
def made(tmp_path: Path) -> Path:
    assert golden.update(tmp_path, ENTRY, draw) == "new"
    return tmp_path


def elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(golden, "machine_class", lambda: "another machine")


def test_the_same_picture_matches_and_leaves_nothing_behind(made: Path, tmp_path: Path) -> None:
    result = golden.check(made, ENTRY, tmp_path / "diff", draw)
    assert result.matches
    assert result.words == "exact"
    assert not (tmp_path / "diff").exists()


def test_one_pixel_by_one_step_is_caught(made: Path, tmp_path: Path) -> None:
    result = golden.check(made, ENTRY, tmp_path / "diff", changed(1, 1))
    assert not result.matches
    assert "1 of 1200 pixels" in result.words
    assert result.difference == tmp_path / "diff" / "hair.diff.png"
    assert png.read(result.difference).shape == (30, 40 * 3 + 4, 3)


@pytest.mark.parametrize("other", [False, True])
def test_one_pixel_planted_in_the_golden_picture_is_caught_on_every_machine(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, other: bool
) -> None:
    image = png.read(made / "hair.png").copy()
    image[3, 4, 0] ^= 1
    write_image(made / "hair.png", image)
    if other:
        elsewhere(monkeypatch)
    result = golden.check(made, ENTRY, tmp_path / "diff", draw)
    assert not result.matches
    assert "is not the image that hashes.json was written for" in result.words


def test_the_tolerance_elsewhere_is_the_stated_one(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    elsewhere(monkeypatch)
    few = int(golden.MOST_OVER * 1200)
    assert golden.check(made, ENTRY, tmp_path, changed(few, golden.THRESHOLD + 1)).matches
    assert not golden.check(made, ENTRY, tmp_path, changed(few + 1, golden.THRESHOLD + 1)).matches
    assert golden.check(made, ENTRY, tmp_path, changed(100, 4)).matches
    result = golden.check(made, ENTRY, tmp_path, changed(few, 127))
    assert result.comparison.rmse > golden.MOST_RMSE
    assert not result.matches


def test_missing_pictures_and_hashes_are_mismatches(made: Path, tmp_path: Path) -> None:
    assert "fur.png is missing" in golden.check(made, Entry("fur", "fur"), tmp_path, draw).words
    (made / golden.HASHES).unlink()
    assert "its hash in hashes.json is missing" in golden.check(made, ENTRY, tmp_path, draw).words


def test_another_size_and_a_failed_simulation_are_mismatches(made: Path, tmp_path: Path) -> None:
    result = golden.check(made, ENTRY, tmp_path / "diff", lambda entry, directory: np.zeros((3, 4, 3), np.uint8))
    assert not result.matches
    assert "sizes differ: 40x30 against 4x3" in result.words
    assert result.difference.exists()

    def explode(entry: Entry, directory: Path) -> np.ndarray:
        raise SimulationError("frame 2: strand 7 is not finite")

    assert "strand 7 is not finite" in golden.check(made, ENTRY, tmp_path, explode).words


def test_update_writes_only_what_changed(made: Path) -> None:
    before = {name: (made / name).read_bytes() for name in os.listdir(made)}
    assert set(before) == {"hair.png", "hashes.json"}
    assert golden.update(made, ENTRY, draw) is None
    assert {name: (made / name).read_bytes() for name in os.listdir(made)} == before
    change = golden.update(made, ENTRY, changed(1, 1))
    assert change.startswith("changed: 1 of 1200 pixels")
    assert golden.check(made, ENTRY, made / "diff", changed(1, 1)).matches
    assert not golden.check(made, ENTRY, made / "diff", draw).matches


def test_a_second_class_of_machine_adds_its_hash_and_is_exact_from_then_on(
    made: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    picture = (made / "hair.png").read_bytes()
    elsewhere(monkeypatch)
    assert golden.update(made, ENTRY, changed(1, 10)) == "hash added for this class of machine"
    assert (made / "hair.png").read_bytes() == picture
    assert golden.check(made, ENTRY, made, changed(1, 10)).words == "exact"
    assert not golden.check(made, ENTRY, made, changed(1, 11)).matches
    monkeypatch.undo()
    assert golden.check(made, ENTRY, made, draw).words == "exact"


def test_a_new_picture_forgets_the_hashes_of_the_old_one(made: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    elsewhere(monkeypatch)
    golden.update(made, ENTRY, changed(1000, 100))
    record = json.loads((made / golden.HASHES).read_text())["images"]["hair"]
    assert list(record["classes"]) == ["another machine"]
    assert record["picture"] == png.pixels_sha256(png.read(made / "hair.png"))


def test_entries_no_longer_listed_are_removed(made: Path) -> None:
    golden.update(made, Entry("fur", "fur"), draw)
    assert golden.prune(made, [ENTRY]) == ["fur"]
    assert sorted(os.listdir(made)) == ["hair.png", "hashes.json"]
    assert golden.prune(made, [ENTRY]) == []


def test_the_list_is_read_with_its_defaults(tmp_path: Path) -> None:
    (tmp_path / golden.LIST).write_text(
        "- preset: figures/fig02\n- {preset: ./own.yaml, name: b, frame: 3, size: 160x120, set: [wind.strength=3]}\n"
    )
    assert golden.read_entries(tmp_path) == [
        Entry("figures-fig02", "figures/fig02"),
        Entry("b", "./own.yaml", ("wind.strength=3",), 3, (160, 120)),
    ]
    entries = golden.read_entries(tmp_path)
    assert golden.select(entries, ["b"]) == entries[1:]
    with pytest.raises(UsageError, match="no golden image is named 'c'; there are figures-fig02, b"):
        golden.select(entries, ["c"])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "must be a list"),
        ("preset: hair", "must be a list"),
        ("- hair", "entry 1: must be a mapping"),
        ("- preset: hair\n- {preset: 3}", "entry 2: 'preset' must be"),
        ("- {preset: hair, frames: 3}", "unknown key 'frames'"),
        ("- {preset: hair, frame: 0}", "'frame' must be a whole number from 1"),
        ("- {preset: hair, frame: yes}", "'frame' must be"),
        ("- {preset: hair, size: 800}", "'size' must be"),
        ("- {preset: hair, size: 0x10}", "'size' must be"),
        ("- {preset: hair, set: wind.strength=3}", "'set' must be a list"),
        ("- {preset: hair, name: ../hair}", "'name' must be letters"),
        ("- preset: hair\n- preset: hair", "two entries are named 'hair'"),
        *(
            (f"- {{preset: hair, {key}: {value}}}", f"entry 1: '{key}' must be a number from 0 to")
            for key, value in (("allow", 101), ("allow", "few"), ("rmse", -1), ("rmse", "true"))
        ),
        ("- [", "not YAML"),
        ("- !!python/object:os.system {}", "not YAML"),
    ],
)
def test_faults_of_the_list_are_named(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / golden.LIST).write_text(text)
    with pytest.raises(UsageError, match=rf"golden\.yaml: .*{words}"):
        golden.read_entries(tmp_path)


def test_a_folder_without_a_list_and_damaged_hashes_are_named(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"golden\.yaml: no such file"):
        golden.read_entries(tmp_path)
    for text in ("{", "[]", '{"images": {"hair": 3}}'):
        (tmp_path / golden.HASHES).write_text(text)
        with pytest.raises(UsageError, match=r"hashes\.json: "):
            golden.read_hashes(tmp_path)


def test_an_entry_may_have_a_tolerance_of_its_own(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "golden.yaml").write_text("- {preset: hair, allow: 0.5, rmse: 4}\n- {preset: fur}\n")
    wide, usual = golden.read_entries(tmp_path)
    assert (wide.most_over, wide.most_rmse, usual.most_over, usual.most_rmse) == (0.005, 4.0, 0.001, 1.0)
    wide = replace(ENTRY, most_over=wide.most_over, most_rmse=wide.most_rmse)
    draw_wrong = changed(6, golden.THRESHOLD + 20)  # RMSE 1.14
    assert not golden.check(made, wide, tmp_path, draw_wrong).matches
    elsewhere(monkeypatch)
    assert golden.check(made, wide, tmp_path, draw_wrong).matches
    assert not golden.check(made, ENTRY, tmp_path, draw_wrong).matches
    assert not golden.check(made, wide, tmp_path, changed(7, golden.THRESHOLD + 1)).matches
    assert not golden.check(made, wide, tmp_path, changed(6, 127)).matches
