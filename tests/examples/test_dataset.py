"""The example that writes a labelled data set: its files, its cameras, and that a set can be made in parts."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import strandcli
from strandcli.study.axes import Request
from strandcli.study.pictures.subject import Subject

SCRIPT = Path(__file__).resolve().parents[2] / "examples" / "dataset.py"
SMALL = ["--size", "64", "48", "--strands", "300"]


@pytest.fixture(scope="module")
def dataset() -> Any:
    spec = importlib.util.spec_from_file_location("dataset", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_a_small_set(dataset: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
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


def test_bad_input_is_one_line(dataset: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
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
