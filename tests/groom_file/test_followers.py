"""Strands of a file that follow those of them that are simulated."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from groom_file_kit import Strand, hanging, scene, write
from strandcli.draw.common.scratch import Scratch
from strandcli.errors import UsageError
from strandcli.groom.blocks import unpack
from strandcli.groom.followers import Followers
from strandcli.groom_file.following import guided
from strandcli.run.stages import RunOptions, SimulationStage
from strandcli.scene import SceneError
from strandcli.scene.model import Scene
from strandcli.scene.motion import emitter_pose
from strandcli.study import find, sweep
from strandcli.study.motion import Motion
from strandcli.study.sweep import Request

Floats = npt.NDArray[np.float64]

ROD: dict[str, Any] = {"solver": "rod", "rod.rest": "sag_free", "emitter.groom.scale": 0.1, "emitter.particles": 12}
WIND = {"wind": {"strength": 5.0, "direction": [1.0, 0.0, 0.4], "gust": 0.5}}
FALL: dict[str, Any] = {"gravity": {}}


def moving(path: Path, **settings: Any) -> Scene:
    """A scene of simulated strands of a file; ``__`` for dots."""
    given = {key.replace("__", "."): value for key, value in settings.items()}
    return scene(path, **{"rules": [FALL, WIND], "detail": None, **ROD, **given})


def stage_of(given: Scene) -> tuple[SimulationStage, Followers]:
    stage = SimulationStage(given, [1], None, RunOptions())
    assert isinstance(stage.children, Followers)
    return stage, stage.children


def follow(children: Followers, positions: npt.NDArray[np.float32], at: float = 0.0) -> npt.NDArray[np.float32]:
    """The strands in the order of the file, (k, points, 3)."""
    out, _ = children.grow(positions, positions, at, children.select(positions)[1], Scratch())
    rows = unpack(out, children.groom.strands)[:, 1:]
    return rows[np.argsort(children.groom.places)]


def drawn(given: Scene, frame: int) -> npt.NDArray[np.float32]:
    stage, children = stage_of(given)
    moved = stage.begin(frame)
    return follow(children, moved.positions, (frame - 1) / given.time.fps)


def lengths(rows: npt.NDArray[np.floating]) -> Floats:
    """(strands,) metres."""
    return np.asarray(np.linalg.norm(np.diff(rows.astype(float), axis=1), axis=2).sum(1))


def curls(count: int, points: int = 40, seed: int = 3) -> list[Strand]:
    """Curled strands of unequal lengths that hang from a plate."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 1, points)
    found = []
    for _ in range(count):
        x, z = rng.uniform(-1, 1, 2)
        size, phase = rng.uniform(1.5, 2.5), rng.uniform(0, 6)
        wave = 0.12 * t[:, None] * np.stack([np.cos(25 * t + phase), 0 * t, np.sin(25 * t + phase)], 1)
        found.append((np.stack([x + 0 * t, -size * t, z + 0.3 * t**2], 1) + wave).astype(np.float32))
    return found


@pytest.mark.parametrize("solver", ["rod", "thesis"])
def test_the_first_frame_has_the_points_of_the_file(solver: str, tmp_path: Path) -> None:
    strands = hanging([17] * 200)
    given = moving(write(tmp_path / "a.data", strands), solver=solver, emitter__groom__guides=20)
    wanted = np.float32(0.1) * np.stack(strands)
    found = drawn(given, 1)
    assert (found == (np.stack(strands).astype(float) * 0.1).astype(np.float32)).all()
    assert np.abs(drawn(given, 4) - wanted).max() > 1e-3  # and then they move
    assert given.emitter.strands == 20
    assert given.drawn_strands == 200


def test_without_forces_strands_stay(tmp_path: Path) -> None:
    given = moving(write(tmp_path / "a.data", curls(150)), rules=[FALL], emitter__groom__guides=30)
    first = drawn(given, 1)
    assert np.abs(drawn(given, 12) - first).max() < 1e-5 * lengths(first).max()


def test_where_guides_move_rigidly_so_do_all_strands(tmp_path: Path) -> None:
    key = {"time": 0.0, "position": (0.1, 0.0, 0.2), "rotation": (20.0, -10.0, 30.0)}
    there = {"time": 0.5, "position": (0.4, 0.3, -0.1), "rotation": (150.0, 70.0, -80.0)}
    given = moving(
        write(tmp_path / "a.data", curls(300)), emitter__groom__guides=40, rules=[FALL, {"emitter_motion": {}}],
        emitter__keys=[key, there],
    )  # fmt: skip
    _, children = stage_of(given)
    for time in (0.0, 0.31, 0.5):
        now, start = emitter_pose(given.emitter, time), emitter_pose(given.emitter, 0.0)
        turn = np.array(now.rotation) @ np.array(start.rotation).T
        rows = children.rest.reshape(*children.rest.shape[:2], 3, -1).astype(float)
        moved = np.einsum("ij,brjl->bril", turn, rows - np.array(start.translation)[:, None])
        moved += np.array(now.translation)[:, None]
        found = follow(children, moved.reshape(children.rest.shape).astype(np.float32), time)
        wanted = np.stack(curls(300)).astype(float) * 0.1 @ np.array(now.rotation).T + now.translation
        assert np.abs(found - wanted).max() < 2e-6


def test_lengths_are_kept_and_roots_go_with_the_emitter(tmp_path: Path) -> None:
    key = {"time": 0.0, "position": (0.0, 0.0, 0.0)}
    there = {"time": 0.4, "position": (0.1, 0.05, 0.0), "rotation": (0.0, 60.0, 25.0)}
    given = moving(
        write(tmp_path / "a.data", curls(300)), rules=[{"emitter_motion": {}}, FALL, WIND],
        emitter__keys=[key, there], emitter__groom__guides=30,
    )  # fmt: skip
    first = drawn(given, 1)
    for frame in (5, 11):
        found = drawn(given, frame)
        segments = [np.linalg.norm(np.diff(rows.astype(float), axis=1), axis=2) for rows in (first, found)]
        assert np.abs(segments[1] - segments[0]).max() < 2e-6 * 0.2
        pose = emitter_pose(given.emitter, (frame - 1) / given.time.fps)
        roots = first[:, 0].astype(float) @ np.array(pose.rotation).T + pose.translation
        assert np.abs(found[:, 0] - roots).max() < 1e-6


def test_a_parting_is_not_blended(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    t = np.linspace(0, 1, 20)[:, None]
    strands = []
    for _ in range(400):
        x, z = rng.uniform(-0.5, 0.5, 2)
        way = np.concatenate([np.sign(x) * 1.5 * t, 0.5 * t * (1 - 2 * t), 0 * t], 1)
        strands.append((np.array([x, 0, z]) + way).astype(np.float32))
    given = moving(write(tmp_path / "a.data", strands), emitter__groom__guides=40, emitter__groom__root="first")
    own = guided(given)
    side = np.sign(own.guides.directions[:, 0])
    following = own.following
    mine = np.sign(following.groom.directions[:, 0])
    other = (side[following.parents] != mine[:, None]) & (following.weights > 0)
    assert not other.any()
    assert following.weights.sum(1) == pytest.approx(1)


def test_guides_are_told_with_how_far_they_are_off(tmp_path: Path) -> None:
    path = write(tmp_path / "a.data", curls(200))
    few, many = (moving(path, emitter__particles=n).emitter.followers for n in (6, 60))
    assert 0.2 > few.deviation_share > 10 * many.deviation_share > 0
    assert few.deviation == pytest.approx(few.deviation_share * 0.25, rel=0.5)


def test_strands_that_follow_a_lost_guide_are_left_out(tmp_path: Path) -> None:
    given = moving(write(tmp_path / "a.data", hanging([14] * 200)), emitter__groom__guides=25)
    stage, children = stage_of(given)
    positions = stage.begin(2).positions.copy()
    all_of = follow(children, positions, 1 / 24)
    positions.reshape(1, -1, 3, 128)[0, 5, 0, 3] = np.nan
    tones, ids = children.select(positions)
    assert 0 < len(tones) < 200
    lost = ((children.following.parents == 3) & (children.following.weights > 0)).any(1)
    assert len(ids) == 200 - lost.sum()
    out, _ = children.grow(positions, positions, 1 / 24, ids, Scratch())
    rows = unpack(out, len(ids))[:, 1:]
    assert (rows == all_of[ids]).all()


def test_followers_leave_solids(tmp_path: Path) -> None:
    ball: dict[str, Any] = {"kind": "sphere", "radius": 0.06, "position": [0.05, -0.12, 0.0], "name": "ball"}
    rules = [FALL, {"wind": {"strength": 8.0, "direction": [1.0, 0.0, 0.0]}}, {"collision": {}}]
    path = write(tmp_path / "a.data", [one - np.float32([1.5, 0, 0]) for one in curls(300)])
    given = moving(path, rules=rules, solids=[ball], emitter__groom__guides=30)
    found = drawn(given, 10).astype(float)
    away = np.linalg.norm(found - np.array(ball["position"]), axis=2)[:, 1:]
    assert away.min() > 0.06 - 2e-5


def test_stubs_are_no_guides(tmp_path: Path) -> None:
    strands = curls(60)
    for one in strands[::5]:
        one[:] = one[0] + (one - one[0]) * 1e-5
    given = moving(write(tmp_path / "a.data", strands), emitter__groom__guides=1000)
    assert given.emitter.strands == 48
    found, first = drawn(given, 10), drawn(given, 1)
    assert np.abs(found[::5] - first[::5]).max() < 1e-4  # and what follows near a root stays there
    with pytest.raises(UsageError, match=r"too close for single precision; take fewer emitter\.particles"):
        moving(tmp_path / "a.data", emitter__particles=90_000, emitter__groom__scale=0.001)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"emitter.particles": 12}, "particles are those of guides"),
        ({"rules": [FALL], "children": {"count": 3}}, "children"),
        ({"rules": [FALL], "emitter.groom.guides": 0}, "guides"),
        ({"rules": [FALL], "emitter.length": 2.0}, "emitter has position, rotation and keys alone"),
    ],
)
def test_what_does_not_go_together_is_told(settings: dict[str, Any], words: str, tmp_path: Path) -> None:
    path = write(tmp_path / "a.data", hanging([6] * 20))
    with pytest.raises((SceneError, UsageError), match=words):
        scene(path, **{key.replace(".", "__"): value for key, value in settings.items()})


def test_motion_of_guides_is_studied_and_pictures_are_not(tmp_path: Path) -> None:
    """Guides have as many particles as a study asks for; fewer of them are simulated where fewer are asked for."""
    given = moving(write(tmp_path / "a.data", hanging([8] * 20)))
    wishes: dict[str, Any] = {"solvers": ("rod",), "substeps": (1, 2), "iterations": (200,), "span": 0.1}
    study = sweep.run(find("motion"), Request(given, "a", strands=5, particles=(4, 7), **wishes))
    errors = {
        (p.parameters["emitter.particles"], p.parameters["time.substeps"]): p.error["median"] for p in study.points[:4]
    }
    assert set(errors) == {(4, 1), (4, 2), (7, 1), (7, 2)}
    assert 0 < errors[7, 2] < errors[4, 2]  # type: ignore[operator]
    assert len(Motion(Request(given, "a", strands=5)).lengths) == 5
    for axis in ("coverage", "quality", "shadow"):
        with pytest.raises(UsageError, match="a: axes of pictures draw strands that are grown, and this preset has"):
            find(axis)(Request(given, "a"))
    still = scene(tmp_path / "a.data")
    with pytest.raises(UsageError, match="a: nothing moves the strands of its file"):
        Motion(Request(still, "a"))
