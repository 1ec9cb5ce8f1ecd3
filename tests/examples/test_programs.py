"""Every program of examples/ runs as its page says, and a labelled data set has its files and cameras."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import strandcli
from cli_runs import ROOT, environment
from examples import against_pyelastica as example
from examples import dataset
from strandcli.study.pictures.subject import Subject
from strandcli.study.sweep import Request

EXAMPLES = ROOT / "examples"
PICTURES = {
    "vortex_rule.py": ("vortex", "vortex/vortex_12.png"), "shadow_model.py": ("mist", "mist/frame_0001.png"),
    "fibre_model.py": ("kajiya", "kajiya/frame_0001.png"), "solid_shape.py": ("ring.png", "ring.png"),
}  # fmt: skip
"""What follows the program, and a picture that it draws."""


def run(folder: Path, program: str, *words: str) -> str:
    """What a program prints that ends well."""
    command = [sys.executable, str(EXAMPLES / program), *words]
    done = subprocess.run(command, cwd=folder, env=environment(), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_each_program_is_run_by_a_test() -> None:
    there = {path.name for path in EXAMPLES.glob("*.py")}
    assert there == {*PICTURES, "guides.py", "against_pyelastica.py", "dataset.py"}
    meshes = Path(__file__).with_name("test_meshes.py").read_text(encoding="utf-8")
    assert "examples/meshes" in meshes


@pytest.mark.long
@pytest.mark.parametrize("program", PICTURES)
def test_programs_draw(program: str, tmp_path: Path) -> None:
    where, picture = PICTURES[program]
    run(tmp_path, program, where)
    with Image.open(tmp_path / picture) as image:
        assert any(low < high for low, high in image.convert("RGB").getextrema())


@pytest.mark.long
def test_guides_are_compared_with_all_strands(tmp_path: Path) -> None:
    preset = tmp_path / "moving.yaml"
    preset.write_text("extends: groom\ntime: {frames: 6}\nrules: [gravity, stiffness, elasticity]\n")
    lines = run(tmp_path, "guides.py", str(preset), "--guides", "20", "40", "--frames", "6").splitlines()
    assert [line.split()[1] for line in lines] == ["guides:"] * 3
    assert lines[0].split()[2] == "0.000"  # all strands beside themselves


def test_without_pyelastica_one_line_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "elastica", None)
    assert example.main([]) == 1
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err == "PyElastica is not installed here: pip install pyelastica\n"


def test_a_strand_comes_to_rest_near_the_elastica_and_nearer_with_more_segments() -> None:
    few, more = (example.of_strandcli(10.0, segments, 3) for segments in (9, 18))
    assert few.error == pytest.approx(0.0102, rel=0.05)
    assert 3.5 < few.error / more.error < 4.5
    assert few.seconds > 0
    assert example.off((0.0, 0.0, 0.0), 10.0) == pytest.approx(0.958, abs=0.002)


def test_a_step_is_stable_where_the_next_smaller_one_agrees() -> None:
    def run(step: float, error: float) -> Any:
        return example.Run("PyElastica", 10, step, 1, error, 1.0)

    wild, coarse, fine = run(0.4, float("nan")), run(0.3, 0.004), run(0.2, 0.00401)
    assert example.settled([wild, coarse, fine]) is coarse
    assert example.settled([wild, coarse]) is None


SMALL = ["--size", "64", "48", "--strands", "300"]


def test_a_small_set(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    whole, part = tmp_path / "whole", tmp_path / "part"
    assert dataset.main(["--count", "2", "-o", str(whole), *SMALL]) == 0
    listed = json.loads((whole / "dataset.json").read_text())
    assert [sample["name"] for sample in listed["samples"]] == ["00000", "00001"]
    for sample in listed["samples"]:
        check_sample(whole / sample["name"], sample)
    # the second sample alone is the same, and is listed beside what is there
    assert dataset.main(["--count", "1", "--first", "1", "--threads", "1", "-o", str(part), *SMALL]) == 0
    for name in ("frame_0001.png", "camera.json", "scene.yaml", "depth_0001.npz"):
        assert (part / "00001" / name).read_bytes() == (whole / "00001" / name).read_bytes()
    assert dataset.main(["--count", "1", "-o", str(part), *SMALL]) == 0
    assert json.loads((part / "dataset.json").read_text()) == listed


def check_sample(folder: Path, sample: dict[str, Any]) -> None:
    """What a sample holds agrees: strands' particles are seen by its matrices where its layers say."""
    camera = json.loads((folder / "camera.json").read_text())
    k, r, t = (np.array(camera[name]) for name in ("K", "R", "t"))
    np.testing.assert_allclose(r @ r.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(r) == pytest.approx(1)
    depth, ids = (np.load(folder / f"{name}_0001.npz")[name] for name in ("depth", "strand_id"))
    assert depth.shape == ids.shape == (camera["height"], camera["width"]) == (48, 64)
    assert sample["hair_share"] > 0.02
    scene = strandcli.load(str(folder / "scene.yaml"))
    assert scene.seed == camera["seeds"]["scene"]
    (frame,) = strandcli.render(scene)
    with Image.open(folder / "frame_0001.png") as image:
        np.testing.assert_array_equal(np.asarray(image), frame.image)
    # each pixel of a strand lies on the polyline of that strand, within what curves and pixels take
    subject = Subject(Request(scene, "sample", size=scene.image.size, strands=scene.drawn_strands))
    subject.move()
    rows, columns = np.nonzero(ids >= 0)
    there = depth[rows, columns]
    pixels = np.stack([columns + 0.5, rows + 0.5, np.ones(len(rows))], 1)
    points = ((pixels @ np.linalg.inv(k).T) * there[:, None] - t) @ r
    strands = subject.points()[ids[rows, columns], 1:]
    off = np.min(np.linalg.norm(strands - points[:, None], axis=2), 1)
    spacing = np.linalg.norm(np.diff(strands, axis=1), axis=2).max(1)
    assert (off < 0.6 * spacing + 1.5 * there / k[0, 0]).all()


def test_bad_input_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        dataset.main(["--count", "0"])
    assert ended.value.code == 2
    capsys.readouterr()
    assert dataset.main(["--strands", "0", "-o", str(tmp_path / "set")]) == 2
    assert "emitter.strands" in capsys.readouterr().err
    (tmp_path / "file").write_text("")
    assert dataset.main(["-o", str(tmp_path / "file"), *SMALL]) == 4
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("dataset.py: ")
