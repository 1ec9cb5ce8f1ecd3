"""Objects of a file: their names and which strand is of which, through reading, edits, selection and writing."""

from __future__ import annotations

import json
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import exchange_kit as kit
import strandcli
from abc_kit import Builder
from cli_runs import Runner
from strandcli.errors import UsageError
from strandcli.exchange import edits, objects, resample
from strandcli.exchange.files import ReadOptions, read, write
from strandcli.exchange.strands import Attribute, Strands, TimeSample
from strandcli.groom_file.read import from_scene
from strandcli.output import png

ODD = ("../../etc/passwd", "a b\tc", "\x1b[31mred", "‮gnp", "x" * 5000, "", "/", "\x00", "眉", "9 lives", "a:b", 'q"\\')
names_of_objects = st.lists(st.text(max_size=12) | st.sampled_from(ODD), min_size=1, max_size=6)


def of(counts: list[int], names: tuple[str, ...], numbers: Any) -> Strands:
    """Strands of which the x axis tells the object, and y the strand."""
    found = kit.of([np.stack([np.full(n, float(numbers[i])), i + np.arange(n) / 64, np.sin(np.arange(n) + i)], axis=1)
                    for i, n in enumerate(counts)])  # fmt: skip
    attributes = {"width": Attribute("point", np.arange(sum(counts)).astype(np.float32) + 1)}
    if len(names) > 1:
        attributes["object"] = Attribute("strand", np.asarray(numbers, np.int32))
    return Strands(found.first, found.points, attributes, objects=names)


def hair() -> Strands:
    """Three objects whose strands take turns."""
    return of([3, 4, 2, 5, 3, 2, 3, 6], ("/head/brows", "/head/lashes", "/beard/beardShape"), [0, 1, 2, 0, 1, 2, 0, 0])


def by_name(strands: Strands) -> dict[str, list[bytes]]:
    """The bits of the strands of each object, sorted, by its short name."""
    numbers = objects.numbers(strands)
    found: dict[str, list[bytes]] = {}
    for number, name in enumerate(objects.short_names(strands.objects)):
        rows = np.flatnonzero(numbers == number)
        mine = [strands.points[strands.first[i] : strands.first[i + 1]].tobytes() for i in rows]
        found[name] = sorted(mine)
    return found


@settings(max_examples=20, deadline=None)
@given(names=names_of_objects, suffix=st.sampled_from([".abc", ".npz", ".obj"]), seed=st.integers(0, 99))
@example(names=["\\", 'q"\\'], suffix=".obj", seed=0)
def test_strands_stay_with_their_names(names: list[str], suffix: str, seed: int) -> None:
    """Whatever the names are: each format gives other ones to those that it does not take, and all differ."""
    generator = np.random.default_rng(seed)
    counts = generator.integers(2, 6, len(names) + 4).tolist()
    numbers = [*range(len(names)), *generator.integers(0, len(names), 4).tolist()]
    held = of(counts, tuple(names), generator.permutation(numbers))
    with tempfile.TemporaryDirectory() as folder:
        write(Path(folder, f"a{suffix}"), held)
        found = read(Path(folder, f"a{suffix}"))
        assert [one.name for one in Path(folder).iterdir()] == [f"a{suffix}"]
    legal = objects.written_names(held.objects, str)
    assert len(set(legal)) == len(legal)
    assert len(found.objects) == len(held.objects)
    ours, theirs = by_name(replace(held, objects=tuple(f"{i}" for i in range(len(names))))), by_name(found)
    assert sorted(ours.values()) == sorted(theirs.values())
    if all(name.isascii() and name.isalpha() and len(name) < 200 for name in names) and len(set(names)) == len(names):
        assert theirs == by_name(held)


@pytest.mark.parametrize("suffix", [".abc", ".usdc", ".npz"])
def test_objects_go_from_format_to_format(suffix: str, tmp_path: Path) -> None:
    held = hair()
    assert write(tmp_path / f"a{suffix}", held) == []
    found = read(tmp_path / f"a{suffix}")
    assert sorted(objects.short_names(found.objects)) == ["beard", "brows", "lashes"]
    assert by_name(found) == by_name(held)
    alone = read(tmp_path / f"a{suffix}", ReadOptions(objects=("brows",)))
    assert objects.short_names(alone.objects) == ["brows"]
    assert "object" not in alone.attributes
    assert by_name(alone) == {"brows": by_name(held)["brows"]}
    write(tmp_path / f"b{suffix}", alone)
    assert by_name(read(tmp_path / f"b{suffix}")) == by_name(alone)
    both = read(tmp_path / f"a{suffix}", ReadOptions(objects=("beard", "lashes")))
    assert by_name(both) == {name: by_name(held)[name] for name in ("lashes", "beard")}
    widths = dict(zip(held.points[:, 1].tolist(), held.attributes["width"].values.tolist(), strict=True))
    assert [widths[y] for y in both.points[:, 1].tolist()] == both.attributes["width"].values.tolist()


@pytest.mark.parametrize("suffix", [".abc", ".usdc"])
def test_objects_that_move_keep_their_points(suffix: str, tmp_path: Path) -> None:
    held, path = hair(), tmp_path / f"a{suffix}"
    told = [TimeSample(i / 24, held.points + np.float32([0, 0, i])) for i in range(3)]
    write(path, held, told)
    for wanted in ((), ("lashes",)):
        how = ReadOptions(objects=wanted)
        still = read(path, how)
        seen = kit.moments(path, how)
        for i, one in enumerate(seen):
            want = by_name(replace(held, points=told[i].points))
            found = by_name(replace(still, points=one.points))
            assert found == {name: want[name] for name in found}


@pytest.mark.parametrize(
    "edit",
    [lambda strands: edits.fixed(strands, turn=False), edits.reversed_all,
     lambda strands: resample.some(strands, 4, 1), lambda strands: edits.turned(strands, "z", "y"),
     lambda strands: resample.resampled(strands, 5), lambda strands: resample.simplified(strands, 1e-3)],
)  # fmt: skip
def test_edits_keep_which_strand_is_of_which_object(edit: Any) -> None:
    changed, _ = edit(hair())
    assert changed.objects == hair().objects
    np.testing.assert_array_equal(objects.numbers(changed), changed.roots()[:, 0].astype(int))
    told = objects.table(changed)
    assert sum(one["strands"] for one in told) == changed.count
    assert sum(one["points"] for one in told) == changed.points.shape[0]


def archive(path: Path, *names: str) -> Path:
    """An archive of an object of each name, the first of one strand, the next of two."""
    made = Builder()
    parts = []
    for place, name in enumerate(names):
        points = np.arange(9 * (place + 1)).reshape(-1, 3).astype("<f4") + 100 * place
        parts.append(made.curves(name, points, [3] * (place + 1)))
    path.write_bytes(made.finish(*parts))
    return path


def test_info_lists_objects_and_convert_takes_one(tmp_path: Path, run: Runner) -> None:
    path = archive(tmp_path / "a.abc", "brows", "lashes", "‮\x1b[31m")
    told = run("info", str(path))
    assert "  object     brows: 1 strand, 3 points\n  object     lashes: 2 strands, 6 points" in told.out
    assert told.out.replace("\n", "").isprintable()
    listed = json.loads(run("info", str(path), "--json").out)["objects"]
    assert listed[1] == {"name": "lashes", "path": "/lashes", "strands": 2, "points": 6}
    assert json.loads(run("info", str(path), "--object", "/lashes", "--json").out)["strands"] == 2
    assert run("convert", str(path), str(tmp_path / "b.npz"), "--object", "lashes", "--object", "brows").code == 0
    with np.load(tmp_path / "b.npz") as arrays:
        assert arrays["object_names"].tolist() == ["brows", "lashes"]
        assert arrays["object"].tolist() == [0, 1, 1]
    wrong = run("convert", str(path), str(tmp_path / "c.npz"), "--object", "lashs")
    assert wrong.code == 2
    assert "has no object 'lashs'; did you mean 'lashes'? there are brows, lashes, " in wrong.err
    assert len(wrong.err.splitlines()) == 1
    assert not (tmp_path / "c.npz").exists()


def test_commands_that_draw_take_objects(tmp_path: Path, run: Runner) -> None:
    whole = archive(tmp_path / "whole.abc", "brows", "lashes")
    write(tmp_path / "lashes.abc", read(whole, ReadOptions(objects=("lashes",))))
    assert "3 strands" in run("plan", whole).out
    assert "2 strands" in run("plan", whole, "--object", "lashes").out
    assert run("export", whole, tmp_path / "a.npz", "-f", "1", "--object", "/brows").code == 0
    assert read(tmp_path / "a.npz").count == 1
    pictures = {}
    for name, words in {"all": (whole,), "some": (whole, "--object", "lashes"), "alone": ("lashes.abc",)}.items():
        file, *more = words
        assert run("info", tmp_path / file, "--picture", tmp_path / f"{name}.png", *more).code == 0
        pictures[name] = png.read(tmp_path / f"{name}.png")
    np.testing.assert_array_equal(pictures["some"], pictures["alone"])
    assert (pictures["all"] != pictures["some"]).any()


def test_a_preset_draws_the_objects_that_it_names(tmp_path: Path) -> None:
    path = archive(tmp_path / "a.abc", "brows", "lashes", "beard")
    for wanted, count in ((["lashes"], 2), (["brows", "beard"], 4), ([], 6)):
        scene = strandcli.load("groom", settings={"emitter.groom.file": str(path), "emitter.groom.object": wanted})
        assert from_scene(scene).strands == count
    with pytest.raises(UsageError, match="has no object 'hair'; there are brows, lashes, beard"):
        strandcli.load("groom", settings={"emitter.groom.file": str(path), "emitter.groom.object": ["hair"]})


def test_names_are_text_wherever_they_go(tmp_path: Path) -> None:
    held = replace(of([2] * len(ODD), ODD, list(range(len(ODD)))), source=hair().source)
    said = write(tmp_path / "a.usda", held)
    assert len(said) == 1
    assert said[0].startswith(".usd takes no such name: object 'a b\tc' is called 'a_b_c', and ")
    assert sorted(one.name for one in tmp_path.iterdir()) == ["a.usda"]
    found = read(tmp_path / "a.usda")
    assert len(found.objects) == len(ODD)
    assert "/strands/眉" in found.objects
    assert all(len(one) < 300 for one in found.objects)
    many = of([2] * 30, tuple(f"o{i}" for i in range(30)), list(range(30)))
    with pytest.raises(UsageError) as error:
        objects.only(many, ["\x1b" * 900], tmp_path)
    assert len(str(error.value)) < 400
    assert "and 20 more" in str(error.value)


@pytest.mark.parametrize(
    ("change", "words"),
    [({"object": np.array([0, 1, 2])}, "2 names, object has numbers from 0 to 2"),
     ({"object": np.array([0, -1, 1])}, "numbers from -1 to 1"),
     ({"object": np.array([0.5, 0, 1])}, "has no whole number for each strand")],
)  # fmt: skip
def test_numbers_of_no_object_are_told(change: dict[str, Any], words: str, tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", positions=np.zeros((3, 2, 3), "f4"), object_names=np.array(["a", "b"]), **change)
    with pytest.raises(UsageError, match=words):
        read(tmp_path / "a.npz")
