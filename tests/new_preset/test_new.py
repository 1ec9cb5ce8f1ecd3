"""`strandcli new`: presets that load and draw as they are, with unit and up axis as files have them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import exchange_kit
import mesh_kit
import strandcli
from cli_runs import Runner
from strandcli.cli.new import preset_file
from strandcli.common.rotations import turning
from strandcli.errors import UsageError
from strandcli.exchange.files import write
from strandcli.exchange.strands import Strands
from strandcli.groom_file.fits import Surface
from strandcli.meshes.make import make_mesh
from strandcli.output import png


def test_a_new_preset_draws_as_it_is_and_is_never_replaced(run: Runner) -> None:
    made = run("new", "mine")
    assert (made.code, made.error()) == (0, "mine.yaml: written; draw it with 'strandcli render mine.yaml -f 1'")
    small = ["--strands", 60, "--set", "children.count=4", "--set", "material.width=0.003", "--set", "time.preroll=0.2"]
    assert run("render", "mine.yaml", "-f", "1", "--size", "64x48", "-q", *small).code == 0
    image = png.read(Path("out/mine/frame_0001.png")).astype(int)
    assert np.ptp(image[16:32, 24:40].sum(axis=2)) > 60, "hair stands before the backdrop"
    Path("mine.yaml").write_text("mine")
    assert "is there already; add --overwrite" in run.refused("new", "mine")
    assert Path("mine.yaml").read_text() == "mine"
    assert run("new", "mine.yaml", "--overwrite", "-q").code == 0
    assert strandcli.load("mine.yaml").title == "Hair on a ball that turns"


def hair(head: mesh_kit.TriangleMesh) -> Strands:
    """Strands straight out of the upper half of a head."""
    rows = np.flatnonzero(head.vertices[:, 1] > 0)[::5]
    tips = np.random.default_rng(5).uniform(0.05, 0.2, (rows.size, 1)) * head.normals[rows]
    points = head.vertices[rows, None] + np.stack([0 * tips, tips], axis=1)
    return exchange_kit.of(list(points.astype(np.float32)))


@pytest.mark.parametrize(("axis", "factor"), [("y", 1.0), ("z", 100.0), ("-x", 1000.0)])
@pytest.mark.parametrize("same", [True, False])
def test_hair_and_head_are_placed_as_they_lie_on_each_other(run: Runner, axis: str, factor: float, same: bool) -> None:
    """The head is in any unit and axis; the hair in the same ones, or in metres with y up."""
    vertices, triangles = mesh_kit.head(40)
    keep = vertices[:, 1] > -0.09  # cut off at the neck, which tells the up axis
    triangles = triangles[keep[triangles].all(axis=1)]
    head = make_mesh(vertices, triangles)
    strands = hair(head)
    turn = factor * turning(axis, "y")
    Path("head.obj").write_bytes(mesh_kit.obj(make_mesh(vertices @ turn, triangles)))
    if same:
        strands = Strands(strands.first, (strands.points @ turn).astype(np.float32))
    write(Path("hair.ply"), strands)
    made = run("new", "both", "--groom", "hair.ply", "--head", "head.obj", "-q")
    assert (made.code, made.err) == (0, "")
    scene = strandcli.load("both.yaml")
    groom, solid = scene.emitter.groom, scene.solids[0]
    assert (solid.up, groom.up) == (axis, axis if same else "y")  # type: ignore[attr-defined]
    assert groom.scale is not None
    roots = groom.scale * strands.roots().astype(np.float64) @ turning(groom.up, "y").T
    surface = Surface(solid)
    assert float(np.abs(surface.nearest(roots).distances).max()) < 1e-3 * surface.size
    assert surface.size == pytest.approx(head.size(), rel=1e-4)
    assert "measured" in Path("both.yaml").read_text()


def test_strands_alone_have_the_axis_that_info_guesses(run: Runner) -> None:
    rng = np.random.default_rng(1)
    roots = rng.normal(size=(300, 3))
    roots *= 9 / np.linalg.norm(roots, axis=1)[:, None]
    roots[:, 2] = np.abs(roots[:, 2])
    points = [np.array([r, r * 1.1, r * 1.1 - [0, 0, 15], r * 1.1 - [0, 0, 25]], np.float32) for r in roots]
    Path("some.data").write_bytes(exchange_kit.data(points))
    Path("in").mkdir()
    assert run("new", "in/some", "--groom", "some.data", "-q").code == 0
    text = Path("in/some.yaml").read_text()
    scene = strandcli.load("in/some.yaml")
    assert (scene.emitter.groom.up, scene.emitter.groom.size) == ("z", 0.4), text
    assert 'file: "../some.data"' in text
    assert "a guess: hair hangs from above" in text


def test_a_head_alone_grows_hair_where_its_attribute_or_its_height_says(run: Runner) -> None:
    vertices, triangles = mesh_kit.head(20)
    Path("head.obj").write_bytes(mesh_kit.obj(make_mesh(7 * vertices, triangles)))
    assert run("new", "grown", "--head", "head.obj", "-q").code == 0
    scene = strandcli.load("grown.yaml")
    assert scene.emitter.shape.above > 0  # type: ignore[union-attr]
    assert "size: 0.28" in Path("grown.yaml").read_text(), "a head of 1.9 has no usual unit"
    mesh = make_mesh(vertices, triangles)
    scalp = (mesh.vertices[:, 1] > 0).astype(np.float32)
    Path("head.ply").write_bytes(mesh_kit.ply(mesh, more={"scalp": scalp}))
    assert run("new", "spread", "--head", "head.ply", "-q").code == 0
    assert strandcli.load("spread.yaml").emitter.shape.density == "scalp"  # type: ignore[union-attr]


@pytest.mark.parametrize(("arguments", "words"), [
    (["con"], "is no name for a preset"), (["a b"], "such as my_hair"), ([".yaml"], "is no name"),
    (["x.txt"], "a preset is a .yaml file"), (["no/x"], "no such folder"), (["x", "--groom", "no.ply"], "no such file"),
    (["x", "--head", "no.ply"], "no such file"), (["-"], "is no name"),
])  # fmt: skip
def test_what_cannot_be_written_is_told_in_a_line(run: Runner, arguments: list[str], words: str) -> None:
    assert words in run.refused("new", *arguments)
    assert [one.name for one in Path().iterdir()] == ["tiny.yaml"]


@settings(max_examples=200, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(name=st.text(max_size=12) | st.from_regex(r"[\w./\\: -]{0,20}", fullmatch=True))
def test_names_stay_in_their_folder(name: str, tmp_path: Path) -> None:
    try:
        found = preset_file(tmp_path / name if name else tmp_path)
    except (UsageError, ValueError):  # a null byte is refused by the system
        return
    assert found.suffix.lower() in (".yaml", ".yml")
    assert found.name.isprintable()
    assert found.parent.is_dir()
