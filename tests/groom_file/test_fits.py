"""Hair of another unit or up axis than its head: told, with what mends it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import exchange_kit
import groom_file_kit as kit
import mesh_kit
from cli_runs import Runner
from strandcli.common.rotations import AXES, turning
from strandcli.errors import UsageError
from strandcli.exchange.files import write
from strandcli.exchange.strands import Strands
from strandcli.groom_file import from_scene
from strandcli.groom_file.fits import Better, Frame, Surface, better
from strandcli.meshes.read import read_mesh
from strandcli.scene.model.solids import BoxSolid, SphereSolid

SHARE = {"m": 1.0, "cm": 100.0, "in": 1 / 0.0254}
HEAD = read_mesh(Path(__file__).parents[2] / "presets/meshes/head.ply")


def hair() -> Strands:
    """Strands straight out of the scalp, of any length."""
    rows = np.flatnonzero(HEAD.attributes["scalp"] > 0.5)[::3]
    tips = np.random.default_rng(5).uniform(0.02, 0.2, (rows.size, 1)) * HEAD.normals[rows]
    points = HEAD.vertices[rows, None] + np.stack([0 * tips, tips], axis=1)
    return exchange_kit.of(list(points.astype(np.float32)))


def turned(strands: Strands, up: str, factor: float) -> Strands:
    """Strands as a file of another up axis and unit has them."""
    points = factor * (strands.points @ turning(up, "y"))
    return Strands(strands.first, points.astype(np.float32))


@pytest.fixture
def head(tmp_path: Path) -> Path:
    path = tmp_path / "head.ply"
    path.write_bytes(mesh_kit.ply(HEAD))
    return path


@pytest.mark.parametrize(("up", "unit"), [("y", "m"), ("y", "cm"), ("z", "m"), ("-x", "in")])
def test_info_tells_the_unit_and_the_up_axis_that_fit_a_head(
    up: str, unit: str, head: Path, tmp_path: Path, run: Runner
) -> None:
    file = tmp_path / "hair.ply"
    write(file, turned(hair(), up, SHARE[unit]))
    found = json.loads(run("info", file, "--on", head, "--json").out)["on"]
    words = run("info", file, "--on", head).out
    if (up, unit) == ("y", "m"):
        assert found["fits"]
        assert found["mend"] is None
        assert "they fit" in words
        return
    assert not found["fits"]
    assert found["mend"]["up"] == up
    assert found["mend"]["scale"] == pytest.approx(1 / SHARE[unit])
    assert found["mend"]["median"] < 1e-6
    assert (f"--up={up}" in words) == (up != "y")
    assert ("--scale" in words) == (unit != "m")
    mends = [] if unit == "m" else ["--scale", str(1 / SHARE[unit])]
    mends += [] if up == "y" else [f"--up={up}"]
    run("convert", file, tmp_path / "mended.ply", *mends)
    assert json.loads(run("info", tmp_path / "mended.ply", "--on", head, "--json").out)["on"]["fits"]


@pytest.mark.parametrize("up", ["y", "-x"])
def test_what_hangs_tells_the_up_axis_where_another_fits_as_well(
    up: str, head: Path, tmp_path: Path, run: Runner
) -> None:
    """Hair in centimetres of a head a tenth smaller lies nearest to this one as if another axis were up."""
    points = hair().points.reshape(-1, 2, 3)
    points = points[points[:, 0, 1] > 0]
    leaving = 0.97 * points[:, 0] + 0.03 / 0.2 * (points[:, 1] - points[:, 0])
    aside = leaving * [1, 0, 1]
    aside *= 0.13 / np.linalg.norm(aside, axis=1, keepdims=True)
    low = aside - [0, 1, 0] * np.random.default_rng(6).uniform(0, 0.3, (len(points), 1))
    points = np.stack([points[:, 0], leaving, aside + leaving * [0, 1, 0], low], axis=1).astype(np.float32)
    write(tmp_path / "hair.ply", turned(exchange_kit.of(list(points)), up, 90))
    found = json.loads(run("info", tmp_path / "hair.ply", "--on", head, "--json").out)["on"]
    assert (found["mend"]["up"], found["mend"]["scale"]) == (up, 0.01)


def test_of_up_axes_that_fit_alike_none_is_taken() -> None:
    """Spikes all over a ball lie on it whatever is up: their unit is told alone. A box whose long side is level fits
    hair with that side upright by two axes."""
    frame = Frame(np.eye(3), np.zeros(3))
    out = np.random.default_rng(3).normal(size=(300, 3))
    roots = 10 * out / np.linalg.norm(out, axis=1, keepdims=True)
    for said in AXES:
        found = better(roots, said, Surface(SphereSolid(name="head", radius=0.1)), frame)
        assert (found.up, found.factor) == (said, 0.01)
    roots = np.random.default_rng(4).uniform(-0.1, 0.1, (300, 3))
    roots[:150, 0], roots[150:, 2], roots[:, 1] = 0.1, -0.1, 2 * roots[:, 1]
    box = Surface(BoxSolid(name="head", size=(0.2, 0.2, 0.4)))
    assert better(roots, "y", box, frame) is None
    assert better(roots, "y", box, frame, "z") == Better("z", 1.0, 0.0)


def test_a_spot_of_hair_and_another_head_fit_nowhere(head: Path, tmp_path: Path, run: Runner) -> None:
    spot = hair().points[:2]
    for name, points in {"spot.ply": np.tile(spot, (30, 1)) + 3, "far.ply": hair().points + 5}.items():
        points = points.astype(np.float32)
        write(tmp_path / name, Strands(np.arange(0, len(points) + 1, 2), points))
        found = json.loads(run("info", tmp_path / name, "--on", head, "--json").out)["on"]
        assert not found["fits"]
        assert found["mend"] is None
    assert "a mesh itself" in run("info", head, "--on", head).err


@pytest.mark.filterwarnings("error")
def test_strands_that_are_not_finite_or_far_too_large_or_none_are_compared_in_a_line(
    head: Path, tmp_path: Path, run: Runner
) -> None:
    points = hair().points.reshape(-1, 2, 3).copy()
    points[7, 0, 1], points[9, 1, 2] = np.nan, np.inf
    for name, some in {"bad.data": points, "huge.data": 1e30 * points[10:], "none.data": points[7:8]}.items():
        (tmp_path / name).write_bytes(exchange_kit.data(list(some.astype(np.float32))))
    assert "they fit" in run("info", tmp_path / "bad.data", "--on", head).out
    assert "neither another unit" in run("info", tmp_path / "huge.data", "--on", head).out
    assert "has no strand that could lie on" in run("info", tmp_path / "none.data", "--on", head).error()


def test_hair_that_is_put_on_a_head_tells_another_up_axis(head: Path, tmp_path: Path) -> None:
    file = tmp_path / "hair.ply"
    settings = {"solids": [{"kind": "mesh", "file": str(head), "name": "head"}], "emitter.groom.on": "head"}
    for factor, up in ((1.0, "x"), (1.0, "y"), (100.0, "x")):
        write(file, turned(hair(), up, factor))
        for said in ("y", up):
            asked = {**settings, "emitter.groom.up": said}
            if factor != 1:
                with pytest.raises(UsageError, match=r"emitter\.groom\.scale multiplied by 0\.01"):
                    from_scene(kit.scene(file, **asked))
                continue
            notes = " ".join(from_scene(kit.scene(file, **asked)).notes)
            assert (f"with emitter.groom.up: {up} " in notes) == (said != up)


def test_hair_that_its_settings_move_is_told_where_its_file_has_it(tmp_path: Path, head: Path) -> None:
    """A `size` takes the place of a scale in what is advised; without a placing that fits, the file's own is."""
    path = tmp_path / "hair.data"
    write(path, hair())
    solid = [{"kind": "mesh", "name": "head", "file": str(head)}]
    size = float(np.ptp(hair().points, axis=0).max())
    for settings, advice in (
        ({"emitter.groom.size": 1000 * size, "emitter.groom.place": "origin"}, "size: null and place: file"),
        ({"emitter.groom.size": 100 * size}, f"emitter.groom.size: {size:.4g} it would be"),
    ):
        with pytest.raises(UsageError) as found:
            from_scene(kit.scene(path, **{"solids": solid, "emitter.groom.on": "head", **settings}))
        assert advice in str(found.value)
        assert "scale multiplied" not in str(found.value)
