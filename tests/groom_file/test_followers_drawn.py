"""Pictures of strands of a file that follow guides."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cli_runs import Runner
from groom_file_kit import SMALL, hanging, write
from strandcli.run import pipeline
from strandcli.scene.model import Scene
from tests.groom_file.test_followers import FALL, ROD, WIND, curls, drawn, moving
from thread_runs import Drawer


def test_points_are_thinned_to_pixels_where_curves_are(tmp_path: Path) -> None:
    path = write(tmp_path / "a.data", curls(150, points=200))
    fine, coarse = (moving(path, curves__tolerance=pixels, image__size=(400, 300)) for pixels in (0.1, 1.0))
    everything = moving(path, curves__mode="off")
    for given in (fine, coarse):
        assert given.curves.mode == "off"
        assert given.emitter.followers.points < everything.emitter.followers.points == 200
        rows = drawn(given, 1).astype(float)
        for own, kept in zip(drawn(everything, 1)[:20].astype(float), rows, strict=False):
            way, begin = np.diff(kept, axis=0), kept[:-1]
            t = np.einsum("psk,sk->ps", own[:, None] - begin, way) / (way * way).sum(1)
            off = np.linalg.norm(own[:, None] - begin - np.clip(t, 0, 1)[..., None] * way, axis=2).min(1).max()
            assert off <= given.emitter.followers.tolerance
    assert fine.emitter.followers.points > coarse.emitter.followers.points
    assert coarse.emitter.followers.tolerance == pytest.approx(10 * fine.emitter.followers.tolerance)


def test_level_of_detail_draws_fewer_and_covers_as_much(tmp_path: Path) -> None:
    path = write(tmp_path / "a.data", hanging([12] * 3000))
    settings = {"emitter__groom__guides": 50, "image__size": (120, 90), "emitter__groom__cover": 3.0}
    whole = moving(path, **settings)
    pixels = 2 * whole.material.width / pixel(whole)
    fewer = moving(path, detail={"pixels": pixels}, **settings)
    assert 600 < fewer.emitter.followers.drawn < 2400
    pictures = [next(pipeline.render(one, [3])) for one in (whole, fewer)]
    assert pictures[0].report["counts"]["strands"] == 3000
    assert pictures[1].report["counts"]["strands"] <= fewer.emitter.followers.drawn
    a, b = (one.image.astype(float) for one in pictures if one.image is not None)
    background = a[0, 0]
    covered = [float((np.abs(one - background).sum(2) > 30).mean()) for one in (a, b)]
    assert covered[1] == pytest.approx(covered[0], rel=0.1)


def pixel(given: Scene) -> float:
    """Metres a pixel at the strands."""
    away = np.linalg.norm(np.subtract(given.camera.position, given.camera.target))
    return float(2 * away * np.tan(np.radians(given.camera.fov / 2)) / given.image.size[1])


def test_the_picture_is_the_same_on_any_number_of_threads(tmp_path: Path) -> None:
    path, widths = tmp_path / "a.npz", np.random.default_rng(2).uniform(0.005, 0.02, (500, 14))
    np.savez(path, positions=np.stack(hanging([14] * 500)), width=widths)
    own = {"emitter.groom.file": str(path), "rules": [FALL, WIND], "emitter.groom.guides": 60, "time.preroll": 0.2}
    settings = {**SMALL, **ROD, "emitter.groom.size": None, **own}
    with Drawer() as drawer:
        hashes = drawer.hashes(preset="groom", overrides=[], settings=settings, shadow_size=64)
    assert hashes == hashes[:1] * 3


def test_a_cache_holds_guides_and_draws_the_same(tmp_path: Path, run: Runner) -> None:
    path = write(tmp_path / "a.data", hanging([14] * 200))
    given = moving(path, emitter__groom__guides=25)
    frames = list(pipeline.render(given, [1, 3], keep_positions=True))
    kept = {frame.number: frame.positions for frame in frames}
    assert kept[3].shape == (25, 12, 3)
    again = list(pipeline.render(given, [1, 3], positions=kept.__getitem__))  # type: ignore[arg-type]
    for one, other in zip(frames, again, strict=True):
        assert one.image is not None
        assert other.image is not None
        assert (one.image == other.image).all()
    plain = ["--set", "solver=rod", "--set", f"rules={[FALL]!r}".replace("'", '"'), "--set", "emitter.groom.guides=25"]
    assert run("simulate", path, "-o", tmp_path / "c", "-f", "1-1", "--particles", 9, *plain).code == 0
    assert np.load(tmp_path / "c" / "positions_0001.npz")["positions"].shape == (25, 9, 3)
    assert "25 of 200 strands, 10 particles each, within" in run.fine("plan", path, *plain).out


def test_a_frame_whose_followers_are_stretched_is_warned_of(tmp_path: Path) -> None:
    """Two guides of 200 strands stretch what follows both; where all are guides none is."""
    told: dict[int, list[str]] = {}
    for guides in (2, 200):
        given = moving(write(tmp_path / "a.data", curls(200)), emitter__groom__guides=guides)
        lines: list[str] = []
        found = list(pipeline.render(given, [1, 8, 9], warn=lines.append))
        worst = [frame.report["error"]["follow_stretch_max"] for frame in found]
        told[guides] = [one for one in lines if "follows" in one]
        assert (max(worst) > 0.01) == (guides == 2)
    assert told[200] == []
    assert len(told[2]) == 1  # the frame after it stretches them no more
    assert told[2][0].startswith("frame 8: guides would change the length of a strand that follows them by 2")
