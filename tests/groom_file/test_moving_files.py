"""Strands of files that move: frame N draws moment N."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import exchange_kit as kit
import groom_file_kit as groom_kit
import strandcli
import usd_kit
from groom_file_kit import shown
from strandcli.errors import SimulationError, UsageError
from strandcli.exchange.files import write
from strandcli.exchange.strands import TimeSample
from strandcli.groom.blocks import unpack
from strandcli.groom_file import from_file
from strandcli.run.stages import RunOptions, SimulationStage

Floats = npt.NDArray[np.float64]
Motion = Callable[[Floats, float], Floats]
COUNTS = (3, 9, 4, 12, 7)
STRANDS = groom_kit.hanging(COUNTS)
FPS = 24.0


def turned(points: Floats, time: float) -> Floats:
    """A turn about y."""
    s, c = np.sin(2 * time), np.cos(2 * time)
    return points @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])


def shifted(points: Floats, time: float) -> Floats:
    return points + time * np.array([0.4, -0.1, 0.2])


def grown(points: Floats, time: float) -> Floats:
    """Growth of whole strands from the first point of each file, (1 + t) times as long."""
    first = np.repeat(points[np.cumsum([0, *COUNTS[:-1]])], COUNTS, axis=0)
    return first + (1 + time) * (points - first)


def file_of(folder: Path, form: str, motion: Motion, times: Sequence[float]) -> Path:
    """Strands at so many times, seconds after the first one of the file, 2 s."""
    held = kit.of(STRANDS)
    samples = [TimeSample(2.0 + t, motion(held.points.astype(np.float64), t).astype(np.float32)) for t in times]
    if form != "ply":
        path = folder / f"moving.{form}"
        write(path, held, samples)
        return path
    for number, sample in enumerate(samples, 7):
        parts = np.split(sample.points, np.cumsum(COUNTS)[:-1])
        (folder / f"moving.{number:04d}.ply").write_bytes(kit.ply(parts))
    return folder / "moving.####.ply"


def off(strand: Any, points: Floats) -> float:
    """How far any of the points of a strand of a file is from the nearest point of the drawn one."""
    away = np.linalg.norm(strand.astype(np.float64)[:, None] - points[None], axis=2)
    return float(away.min(axis=0).max())


def at(motion: Motion, time: float) -> list[Floats]:
    held = kit.of(STRANDS).points.astype(np.float64)
    return np.split(motion(held, time), np.cumsum(COUNTS)[:-1])


@pytest.mark.parametrize(("form", "motion"), [("abc", turned), ("usda", turned), ("ply", turned), ("ply", grown)])
def test_frame_n_draws_moment_n(tmp_path: Path, form: str, motion: Motion) -> None:
    """A file that is drawn by itself has as many frames as moments, and each draws its own."""
    path = file_of(tmp_path, form, motion, [i / FPS for i in range(5)])
    given = groom_kit.scene(path)
    assert (given.time.frames, given.time.fps) == (5, pytest.approx(FPS))
    for number, strands in enumerate(shown(given, range(1, 6))):
        assert max(map(off, strands, at(motion, number / FPS))) < 1e-6


@pytest.mark.parametrize("form", ["abc", "usda"])
def test_between_moments_points_move_in_straight_lines(tmp_path: Path, form: str) -> None:
    path = file_of(tmp_path, form, turned, [0.0, 0.1, 0.5])
    given = groom_kit.scene(path, time__fps=40, time__frames=30)
    for number, strands in zip((3, 5, 6, 17, 21, 25), shown(given, (3, 5, 6, 17, 21, 25)), strict=True):
        time = min((number - 1) / 40, 0.5)
        a, b = (0.0, 0.1) if time < 0.1 else (0.1, 0.5)
        share = (time - a) / (b - a)
        wanted = [p + share * (q - p) for p, q in zip(at(turned, a), at(turned, b), strict=True)]
        assert max(map(off, strands, wanted)) < 1e-6


def test_a_moment_in_the_middle_may_be_the_first(tmp_path: Path) -> None:
    """`start` is a number of numbered files, and seconds of others."""
    for form, start in (("abc", 2.0 + 2 / FPS), ("ply", 9)):
        given = groom_kit.scene(
            file_of(tmp_path, form, turned, [i / FPS for i in range(5)]), emitter__groom__start=start
        )
        assert given.time.frames == 3
        for number, strands in zip((1, 3), shown(given, (1, 3)), strict=True):
            assert max(map(off, strands, at(turned, (number + 1) / FPS))) < 1e-6


def test_a_start_that_the_file_does_not_have_is_told(tmp_path: Path) -> None:
    moving = file_of(tmp_path, "abc", shifted, [i / FPS for i in range(4)])
    with pytest.raises(UsageError, match=r"its last moment, in seconds, is 2\.125, before emitter\.groom\.start, 3"):
        groom_kit.scene(moving, emitter__groom__start=3.0)
    numbered = file_of(tmp_path, "ply", shifted, [0.0, 1.0])
    with pytest.raises(UsageError, match=r"its last file is 8, before emitter\.groom\.start, 9"):
        groom_kit.scene(numbered, emitter__groom__start=9.0)
    still = groom_kit.scene(tmp_path / "moving.0007.ply", emitter__groom__start=1.0)
    assert any("does not move" in line for line in from_file(still.emitter.groom, still.seed).notes)


def test_a_missing_numbered_file_is_named(tmp_path: Path) -> None:
    path = file_of(tmp_path, "ply", turned, [i / FPS for i in range(5)])
    (tmp_path / "moving.0009.ply").unlink()
    given = groom_kit.scene(path)
    assert given.time.frames == 5
    shown(given, (1, 2, 5))
    with pytest.raises(UsageError, match=r"moving\.0009\.ply: there is no such file"):
        shown(given, (1, 3))


def test_strands_that_come_and_go(tmp_path: Path) -> None:
    """Each frame has the strands of its own moment, and at frames between those of the one before."""
    for number, some in enumerate((STRANDS, STRANDS[:2], [*STRANDS, STRANDS[0] + 1]), 1):
        (tmp_path / f"a.{number}.ply").write_bytes(kit.ply(some))
    given = groom_kit.scene(tmp_path / "a.%d.ply")
    for strands, wanted in zip(
        shown(given, (1, 2, 3)), (STRANDS, STRANDS[:2], [*STRANDS, STRANDS[0] + 1]), strict=True
    ):
        assert len(strands) == len(wanted)
        assert max(map(off, strands, wanted)) < 1e-6


def test_files_of_other_names_are_not_numbered_ones(tmp_path: Path) -> None:
    """A name with # of a file that is there is that file; where no number fits, the setting is refused."""
    path = groom_kit.write(tmp_path / "a#.data", STRANDS)
    assert groom_kit.scene(path).emitter.strands == len(STRANDS)
    with pytest.raises(strandcli.scene.SceneError, match="no file"):
        groom_kit.scene(tmp_path / "b.####.data")


def test_pictures_do_not_depend_on_frames_drawn_before(tmp_path: Path) -> None:
    """Nor do those of strands that come and go, through an open shutter too."""
    for number, some in enumerate((STRANDS, STRANDS[:2], STRANDS, [*STRANDS, STRANDS[0] + 1]), 1):
        (tmp_path / f"a.{number}.ply").write_bytes(kit.ply([one + np.float32(0.1 * number) for one in some]))
    given = groom_kit.scene(tmp_path / "a.%d.ply", camera__shutter=0.5, camera__samples=4)
    whole = [frame.image for frame in strandcli.render(given)]
    assert len(whole) == 4
    assert all((a != b).any() for a, b in itertools.pairwise(whole))  # type: ignore[operator]
    for number in (2, 4):
        np.testing.assert_array_equal(groom_kit.image(given, number), whole[number - 1])


def test_an_open_shutter_sees_the_way_from_the_frame_before(tmp_path: Path) -> None:
    path = file_of(tmp_path, "abc", shifted, [i / FPS for i in range(4)])
    stage = SimulationStage(groom_kit.scene(path, camera__shutter=0.5), [3], None, RunOptions())
    moved = stage.begin(3)
    assert moved.before is not None
    step = (unpack(moved.positions, 5) - unpack(moved.before, 5))[:, 1:]
    np.testing.assert_allclose(step, np.broadcast_to(np.array([0.4, -0.1, 0.2]) / FPS, step.shape), atol=1e-6)


@pytest.mark.parametrize("change", ["emitter.groom.strands=3", "emitter.groom.up=z"])
def test_edits_are_those_of_the_first_moment(tmp_path: Path, change: str) -> None:
    """A moment drawn as the fourth of a file is what a file of it alone would be."""
    key, value = change.split("=")
    setting = {key: int(value) if value.isdigit() else value}
    path = file_of(tmp_path, "abc", turned, [i / FPS for i in range(4)])
    (fourth,) = shown(groom_kit.scene(path, **setting), (4,))
    alone = groom_kit.scene(path, emitter__groom__start=2 + 3 / FPS, **setting)
    (wanted,) = shown(alone, (1,))
    assert len(fourth) == len(wanted)
    for strand, other in zip(fourth, wanted, strict=True):
        np.testing.assert_allclose(strand, other, atol=1e-6)


def test_numbers_that_are_not_finite_at_a_later_moment_end_the_run(tmp_path: Path) -> None:
    bad = [one.copy() for one in STRANDS]
    bad[1][2] = np.nan
    for number, some in enumerate((STRANDS, bad), 1):
        (tmp_path / f"a.{number}.ply").write_bytes(kit.ply(some))
    given = groom_kit.scene(tmp_path / "a.#.ply")
    shown(given, (1,))
    with pytest.raises(SimulationError, match="frame 2"):
        shown(given, (2,))
    stage = SimulationStage(given, [2], None, RunOptions(keep_going=True))
    assert stage.begin(2).frame.report["counts"]["left_out"] == 1


def test_what_is_not_shown_is_told(tmp_path: Path) -> None:
    path = file_of(tmp_path, "ply", turned, [i / FPS for i in range(5)])
    for frames, words in ((0, []), (9, ["frames from 6 on show its last moment"]), (2, ["2 are in the film"])):
        told: list[str] = []
        SimulationStage(groom_kit.scene(path, time__frames=frames), [1], None, RunOptions(warn=told.append))
        found = [one for one in told if "film" in one or "moment" in one]
        assert len(found) == len(words)
        assert all(a in b for a, b in zip(words, found, strict=True))
        assert any("frame 1 shows moving.0007.ply" in one for one in told)


def test_widths_that_change_with_time_are_told(tmp_path: Path) -> None:
    told = "    float[] widths.timeSamples = {\n 1: [.01],\n 3: [.02],\n }\n"
    path = tmp_path / "a.usda"
    path.write_text(usd_kit.HEAD + usd_kit.prim(STRANDS, more=told))
    given = groom_kit.scene(path)
    assert (
        f"{path}: widths change with time; those of the first moment are drawn"
        in from_file(given.emitter.groom, given.seed).notes
    )


def test_usd_says_itself_what_is_between_its_samples(tmp_path: Path) -> None:
    """A turn about an axis by two samples of its angle is a turn at every frame."""
    path = tmp_path / "a.usda"
    path.write_text(
        """#usda 1.0
(
    timeCodesPerSecond = 30
    framesPerSecond = 30
)
def Xform "a" {
    double xformOp:rotateY.timeSamples = { 10: 0, 40: 90 }
    uniform token[] xformOpOrder = ["xformOp:rotateY"]
    def BasisCurves "b" {
        uniform token type = "linear"
        int[] curveVertexCounts = [3]
        point3f[] points = [(0.3, 0, 0.1), (1, 1, 0), (2, 1, 1)]
    }
}
""",
        "utf-8",
    )
    given = groom_kit.scene(path)
    assert (given.time.frames, given.time.fps) == (31, 30)
    points = np.array([[0.3, 0, 0.1], [1, 1, 0], [2, 1, 1]])
    for number, (strand,) in zip((1, 11, 16, 31), shown(given, (1, 11, 16, 31)), strict=True):
        angle = np.radians((number - 1) * 3)
        s, c = np.sin(angle), np.cos(angle)
        np.testing.assert_allclose(strand, points @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]), atol=1e-6)
