"""What `strandcli export` writes is what is drawn: the same points, bit for bit, in the order of emission."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest

import exchange_kit
import groom_file_kit
from cli_runs import Runner
from strand_kit import scene_of
from strandcli.draw.drawn_strands import DrawnStrands
from strandcli.draw.geometry import curves
from strandcli.exchange.files import read
from strandcli.run.export import drawn_strands
from strandcli.run.pipeline import render
from strandcli.scene.model import Scene

BASE = """\
time: {frames: 3}
emitter: {strands: 300, particles: 6, length: 0.6, jitter: 20}
image: {size: [48, 36], resolver: sorted}
material: {width: 0.004, taper: 0.6}
lights: []
rules:
  - gravity: {}
  - elasticity: {}
"""
SCENES = {
    "straight": BASE + "curves: {mode: off}\n",
    "curves": BASE + "curves: {mode: fixed, level: 2}\n",
    "children": BASE + "curves: {mode: fixed, level: 1}\nchildren: {count: 3}\n",
    "tied": BASE.replace("particles: 6", "particles: 6, tie: {position: [0, 0.5, -1.3]}") + "curves: {mode: fixed}\n",
}


def drawn(scene: Scene, frames: list[int]) -> list[Any]:
    """Of each frame the polylines that are drawn, and the places of their strands in the order of emission."""
    found = []
    flatten, strands = curves.flatten, DrawnStrands.at
    ids: list[Any] = []

    def kept(*given: Any) -> Any:
        lines = flatten(*given)
        found.append((np.diff(lines.first), lines.world.copy(), ids[-1]))
        return lines

    def known(self: DrawnStrands, *given: Any) -> Any:
        ids.append(None if given[5] is None else given[5].copy())
        return strands(self, *given)

    with patch.object(curves, "flatten", kept), patch.object(DrawnStrands, "at", known):
        list(render(scene, frames, threads=1))
    return found


def in_order(per: Any, world: Any, ids: Any) -> Any:
    """(strands, vertices, 3), of strands with as many vertices each, in the order of emission."""
    assert len(set(per.tolist())) == 1
    out = np.empty((len(per), int(per[0]), 3), np.float32)
    out[slice(None) if ids is None else ids] = world.reshape(out.shape)
    return out


@pytest.mark.parametrize("name", SCENES)
def test_points_are_those_that_are_drawn(name: str) -> None:
    scene = scene_of(SCENES[name])
    exported = list(drawn_strands(scene, [1, 3], threads=1))
    pictures = drawn(scene, [1, 3])
    assert [one.number for one in exported] == [1, 3]
    assert len(pictures) == 2
    for one, lines in zip(exported, pictures, strict=True):
        want = in_order(*lines)
        assert one.strands.equal() == want.shape[1]
        assert one.strands.points.tobytes() == want.tobytes()
    assert exported[0].strands.points.tobytes() != exported[1].strands.points.tobytes()
    count = 900 if name == "children" else 300
    assert exported[0].strands.count == count


def test_strands_of_a_file_come_out_as_they_went_in(tmp_path: Path) -> None:
    path = groom_file_kit.write(tmp_path / "a.data", groom_file_kit.hanging([7] * 150))
    scene = groom_file_kit.scene(path, **{"emitter.groom.size": None, "emitter.groom.place": "file"})
    (one,) = drawn_strands(scene, [1], level=0, threads=1)
    assert one.strands.points.tobytes() == read(path).points.tobytes()


def test_widths_fall_evenly_to_the_tip() -> None:
    (one,) = drawn_strands(scene_of(SCENES["curves"]), [1], threads=1)
    per = one.strands.equal()
    want = 0.004 * (1 - 0.6 * np.arange(per) / (per - 1))
    found = one.strands.attributes["width"].values.reshape(-1, per)
    np.testing.assert_allclose(found, np.broadcast_to(want, found.shape), rtol=1e-6)
    scene = scene_of(SCENES["curves"])
    (bare,) = drawn_strands(replace(scene, material=replace(scene.material, width=0.0)), [1], threads=1)
    assert bare.strands.attributes == {}


def test_pieces_lie_on_the_same_curves() -> None:
    scene = scene_of(SCENES["curves"])
    coarse, fine = (next(iter(drawn_strands(scene, [1], level=level, threads=1))).strands for level in (0, 3))
    assert (coarse.equal(), fine.equal()) == (6, 41)
    assert np.array_equal(coarse.points.reshape(-1, 6, 3), fine.points.reshape(-1, 41, 3)[:, ::8])


def test_level_of_detail_and_camera_do_not_matter() -> None:
    text = SCENES["curves"].replace("mode: fixed, level: 2", "mode: adaptive")
    far = text + "detail: {near: 0.1, fraction: 0.01}\ncamera: {position: [0, 0, 60], shutter: 0.5}\n"
    one, other = (next(iter(drawn_strands(scene_of(each), [2], threads=1))).strands for each in (text, far))
    assert one.points.tobytes() == other.points.tobytes()


def test_the_command_writes_all_frames(run: Runner) -> None:
    Path("a.yaml").write_text(SCENES["children"])
    told = list(drawn_strands(scene_of(SCENES["children"]), threads=1))
    assert "900 strands, 9,900 points, 3 frames" in run.fine("export", "a.yaml", "a.abc").err
    found = exchange_kit.moments(Path("a.abc"))
    assert [one.points.tobytes() for one in found] == [one.strands.points.tobytes() for one in told]
    np.testing.assert_allclose([one.seconds for one in found], [n / 24 for n in (1, 2, 3)], rtol=1e-9)
    run.fine("export", "a.yaml", "a.hair", "-f", "2-3")
    for number in (2, 3):
        strands = read(Path(f"a_{number:04d}.hair"))
        assert strands.points.tobytes() == told[number - 1].strands.points.tobytes()
        width = told[number - 1].strands.attributes["width"].values
        assert strands.attributes["width"].values.tobytes() == width.tobytes()
    assert "add --overwrite" in run.refused("export", "a.yaml", "a.abc", "-f", "1")
    run.fine("export", "a.yaml", "b.npz", "-f", "2", "--pieces", "1")
    assert read(Path("b.npz")).equal() == 6
    assert "let the name end in" in run.refused("export", "a.yaml", "b.png")
