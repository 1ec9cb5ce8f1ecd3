"""Strands of a file: drawn point by point, placed, fitted into the picture; what does not go with them is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import exchange_kit
import strandcli
from cli_runs import Runner
from groom_file_kit import Strand, drawn, hanging, scene, write
from strandcli.constants import W
from strandcli.errors import UsageError
from strandcli.exchange import files
from strandcli.exchange.strands import TimeSample
from strandcli.groom_file import from_file, rows
from strandcli.run import pipeline

UNEQUAL = [2, 3, 17, 9, 9, 5, 17, 2] * 20


def off(points: npt.NDArray[np.floating], line: Strand) -> float:
    """Greatest distance of points from a polyline."""
    a, b = line[:-1].astype(float), line[1:].astype(float)
    way = b - a
    t = np.einsum("psk,sk->ps", points[:, None] - a, way) / np.maximum((way * way).sum(1), 1e-30)
    near = a + np.clip(t, 0, 1)[..., None] * way
    return float(np.linalg.norm(points[:, None] - near, axis=2).min(1).max())


def test_equal_strands_are_drawn_in_every_bit(tmp_path: Path) -> None:
    strands = hanging([12] * 300)
    for own, found in zip(strands, drawn(scene(write(tmp_path / "a.data", strands))), strict=True):
        assert own.tobytes() == found.tobytes()


def test_all_points_of_shorter_strands_are_drawn_and_others_lie_between(tmp_path: Path) -> None:
    strands = hanging(UNEQUAL)
    for own, found in zip(strands, drawn(scene(write(tmp_path / "a.data", strands))), strict=True):
        assert len(found) == 17
        rows = [int(np.flatnonzero((found == point).all(1))[0]) for point in own]
        assert rows == sorted(rows)
        assert (rows[0], rows[-1]) == (0, 16)
        assert off(found.astype(float), own) < 1e-6
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(found.astype(float), axis=0), axis=1))])
        assert (np.diff(along) > 0).all()


def test_dense_strands_are_drawn_without_points_that_make_no_difference(tmp_path: Path) -> None:
    t = np.linspace(0, 1, 200)[:, None]
    strands = [
        (one[0] + 0.7 * (one[5] - one[0]) * t + 0.03 * np.sin(9 * t + one[0]) * t).astype(np.float32)
        for one in hanging([6] * 400, seed=8)
    ]
    path = write(tmp_path / "a.data", strands)
    settings = {"image__size": (160, 160), "image__aovs": ("linear", "mask"), "material__taper": 0.9}
    few, every = (
        next(iter(pipeline.render(scene(path, **settings, **more)))) for more in ({}, {"curves__mode": "off"})
    )
    assert few.report["counts"]["segments"] < 0.3 * every.report["counts"]["segments"]
    assert every.report["counts"]["segments"] == 400 * 199
    assert 0 < few.report["error"]["curve_px_max"] <= 0.1
    assert every.report["error"]["curve_px_max"] is None
    one, other = few.aovs["linear"].astype(float), every.aovs["linear"].astype(float)
    assert np.sqrt(((one - other) ** 2).mean()) < 0.04 * other.mean()
    for name, most in (("linear", 0.005), ("mask", 0.02)):  # short wide pieces cover each other as if by chance
        assert abs(few.aovs[name].mean() / every.aovs[name].mean() - 1) < most, name
    assert np.abs(few.image.astype(float) - every.image).mean() < 1


@pytest.mark.parametrize(
    ("up", "turn"),
    [("z", "x z -y"), ("-y", "")],
)
def test_the_up_axis_becomes_y(up: str, turn: str, tmp_path: Path) -> None:
    strands = hanging([6] * 30)
    path = write(tmp_path / "a.data", strands)
    found = drawn(scene(path, emitter__groom__up=up))
    heights = np.concatenate([one[:, 1] for one in found])
    sign = -1 if up.startswith("-") else 1
    assert (heights == sign * np.concatenate(strands)[:, "xyz".index(up[-1])]).all()
    for own, one in zip(strands, found, strict=True):  # a rotation: no mirror image
        a, b = np.diff(own[:4].astype(float), axis=0), np.diff(one[:4].astype(float), axis=0)
        assert np.linalg.det(a) == pytest.approx(np.linalg.det(b), rel=1e-3, abs=1e-9)
    if turn:
        columns = [("-" in part, "xyz".index(part[-1])) for part in turn.split()]
        for own, one in zip(strands, found, strict=True):
            assert (one == np.stack([-own[:, c] if minus else own[:, c] for minus, c in columns], 1)).all()


def test_scale_size_and_place(tmp_path: Path) -> None:
    strands = hanging([6] * 30)
    path = write(tmp_path / "a.data", strands)
    every = np.concatenate(strands).astype(float)
    found = np.concatenate(drawn(scene(path, emitter__groom__scale=0.25)))
    assert (found == np.float32(0.25) * np.concatenate(strands)).all()
    found = np.concatenate(drawn(scene(path, emitter__groom__size=3.0, emitter__groom__place="ground")))
    assert float(np.ptp(found, axis=0).max()) == pytest.approx(3, rel=1e-6)
    assert found[:, 1].min() == pytest.approx(0, abs=1e-6)
    assert 0.5 * (found.min(0) + found.max(0))[[0, 2]] == pytest.approx([0, 0], abs=1e-6)
    found = np.concatenate(drawn(scene(path, emitter__groom__place="origin")))
    assert found - (every - 0.5 * (every.min(0) + every.max(0))) == pytest.approx(0, abs=1e-6)


def test_the_last_point_may_be_the_root(tmp_path: Path) -> None:
    strands = hanging(UNEQUAL)
    path = write(tmp_path / "a.data", strands)
    found = drawn(scene(path, emitter__groom__root="last"))
    assert all((one[0] == own[-1]).all() and (one[-1] == own[0]).all() for own, one in zip(strands, found, strict=True))


def test_strands_that_cannot_be_drawn_are_told_of(tmp_path: Path) -> None:
    strands = hanging([6] * 40)
    bald = [one[:1] for one in strands[:3]]
    path = write(tmp_path / "a.data", [*bald, *strands])
    heard: list[str] = []
    list(pipeline.render(scene(path), draw=False, warn=heard.append))
    assert any("3 strands of fewer than two points, skipped" in words for words in heard)
    strands[7][2, 1] = np.nan
    strands[9][:] = strands[9][0]
    path = write(tmp_path / "b.data", strands)
    heard.clear()
    assert scene(path, emitter__groom__fix=True).emitter.strands == 38
    list(pipeline.render(scene(path, emitter__groom__fix=True), draw=False, warn=heard.append))
    assert any("1 strand not finite" in words and "1 strand without length" in words for words in heard)
    with pytest.raises(UsageError, match=r"b\.data: .*byte"):
        scene(path, emitter__groom__fix=False)
    strands[7][2, 1] = 0
    path = write(tmp_path / "c.data", strands)
    with pytest.raises(UsageError, match=r"c\.data: 1 strand without length \(strand 9 for one\); set emitter\.groom"):
        scene(path, emitter__groom__fix=False)


def test_a_file_that_does_not_tell_its_strands_is_drawn_with_what_its_refusal_says(tmp_path: Path) -> None:
    path = tmp_path / "cloud.ply"
    points = np.random.default_rng(3).normal(size=(60, 3)).astype(np.float32)
    path.write_bytes(exchange_kit.ply([points], told="nothing"))
    with pytest.raises(UsageError, match=r"--set emitter\.groom\.stride=N"):
        scene(path)
    assert scene(path, emitter__groom__stride=12).emitter.strands == 5


def test_some_of_the_strands(tmp_path: Path) -> None:
    strands = hanging([6] * 40)
    path = write(tmp_path / "a.data", strands)
    few, more = (drawn(scene(path, emitter__groom__strands=count)) for count in (10, 20))
    own = {one.tobytes() for one in strands}
    assert len(few) == 10
    assert {one.tobytes() for one in few} < {one.tobytes() for one in more} < own


def test_width_by_how_much_is_covered(tmp_path: Path) -> None:
    few = write(tmp_path / "b.data", hanging([20] * 3))
    found = from_file(scene(few).emitter.groom, 0)  # type: ignore[arg-type]
    assert scene(few).material.width == pytest.approx(np.ptp(found.seen.points, axis=0).max() / 200)
    path = write(tmp_path / "a.data", hanging([20] * 2000))
    one, two = (scene(path, emitter__groom__cover=times).material.width for times in (2.0, 4.0))
    assert two == pytest.approx(2 * one)
    assert scene(path, emitter__groom__cover=None).material.width == 0
    assert scene(path, material__width=0.125).material.width == 0.125
    found = from_file(scene(path).emitter.groom, 0)  # type: ignore[arg-type]
    assert two * found.seen.length == pytest.approx(4 * found.seen.area)


def test_the_emitter_carries_the_strands(tmp_path: Path) -> None:
    strands = hanging(UNEQUAL)
    keys = ({"time": 0.0}, {"time": 1.0, "position": (1.0, 2.0, 3.0), "rotation": (0.0, 90.0, 0.0), "ease": "linear"})
    path = write(tmp_path / "a.data", strands)
    given = scene(path, time__frames=25, time__fps=24, emitter__keys=keys, rules=["emitter_motion"])
    for own, found in zip(strands, drawn(given, 25), strict=True):
        moved = np.stack([own[:, 2], own[:, 1], -own[:, 0]], 1) + np.array([1, 2, 3])
        assert found[[0, -1]] == pytest.approx(moved[[0, -1]], abs=1e-5)
    still = scene(path, time__frames=25, emitter__keys=keys)
    assert all((a == b).all() for a, b in zip(drawn(still, 25), drawn(still, 1), strict=True))


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"emitter__length": 7, "emitter__comb": (1, 0, 0)}, "take out length, comb, or set each to null"),
        ({"children": {"count": 3}}, "grow about strands of the emitter"),
        ({"emitter__groom__scale": 2.0, "emitter__groom__size": 1.0}, "clashes with emitter.groom.size"),
        ({"emitter__groom": None}, "camera.fit: fits strands of a file"),
        ({"camera__keys": [{"time": 0.0}]}, "a camera with keys stands where they say"),
    ],
)
def test_what_does_not_go_with_a_file_is_refused(settings: dict[str, Any], words: str, tmp_path: Path) -> None:
    path = write(tmp_path / "a.data", hanging([6] * 4))
    with pytest.raises(UsageError, match=words.replace(".", r"\.")):
        scene(path, **settings)


def test_strands_asked_for_are_those_of_the_file_and_in_the_text_of_a_preset_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "a.data", hanging([6] * 9))
    assert len(drawn(scene(path, emitter__strands=7))) == 7
    preset = tmp_path / "own.yaml"
    preset.write_text(f"extends: groom\nemitter: {{strands: 7, groom: {{file: {path.name}}}}}\n")
    with pytest.raises(
        UsageError, match=r"own.yaml:2:20: .*strands, .*--strands, or emitter\.groom\.strands, draws fewer"
    ):
        strandcli.load(str(preset))


def test_info_draws_a_picture(tmp_path: Path, run: Runner) -> None:
    path = write(tmp_path / "locks.data", hanging(UNEQUAL))
    assert run("info", path, "--picture", tmp_path / "locks.png").code == 0
    assert (tmp_path / "locks.png").read_bytes().startswith(b"\x89PNG")
    assert "add --overwrite" in run("info", path, "--picture", tmp_path / "locks.png").error()
    assert "--picture" in run("info", path, "--picture", tmp_path / "locks.jpg").error()


def test_one_long_strand_does_not_make_all_of_them_long(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All strands have as many points in memory: where that is many times the file, they get fewer."""
    strands = hanging([6] * 300 + [900])
    path = write(tmp_path / "a.data", strands)
    whole = from_file(scene(path).emitter.groom, 0)
    assert whole.points == 900
    monkeypatch.setattr(rows, "ENOUGH", 0)
    found = from_file(scene(path).emitter.groom, 1)  # of another seed it is read again
    most = rows.PADDED * (6 * 300 + 900) // (-(-301 // W) * W) - 1  # a row is before the root
    assert found.points == most
    (words,) = [one for one in found.notes if "for memory" in one]
    assert f"strands of up to 900 points are drawn with {most} each" in words
    lines = drawn(scene(path))
    moving = tmp_path / "b.abc"
    points = exchange_kit.of(strands).points
    files.write(moving, exchange_kit.of(strands), [TimeSample(0.0, points), TimeSample(1 / 24, points + np.float32(1))])
    for one, other in zip(drawn(scene(moving, time__frames=2), 2), lines, strict=True):
        np.testing.assert_allclose(one, other + 1, atol=1e-5)
    told = float(words.split("at most ")[1].split(" m off")[0])
    assert all(off(own, line) <= 1.01 * told + 1e-6 for own, line in zip(strands, lines, strict=True))
