"""`strandcli info` and `strandcli convert`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import exchange_kit as kit
from cli_runs import Runner
from exchange.test_edits import head
from strandcli.exchange.files import read


@pytest.fixture
def run(run: Runner) -> Runner:
    Path("a.hair").write_bytes(kit.hair(list(head())))
    return run


def test_info_tells_facts_and_what_mends(run: Runner) -> None:
    words = run.fine("info", "a.hair")
    assert "strands    200" in words.out
    assert "guess      up is y" in words.out
    data = json.loads(run("info", "a.hair", "--json").out)
    assert (data["strands"], data["points"], data["format"]) == (200, 4000, ".hair")
    assert data["faults"] == []


def test_the_mend_that_is_told_mends(run: Runner) -> None:
    turned = head()[:, ::-1] @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], np.float32)
    Path("b.data").write_bytes(kit.data(list(turned)))
    mends = [one["mend"] for one in json.loads(run("info", "b.data", "--json").out)["faults"]]
    assert sorted(mends) == ["--reverse", "--up z"]
    assert run("convert", "b.data", "c.npz", *" ".join(mends).split()).code == 0
    assert json.loads(run("info", "c.npz", "--json").out)["faults"] == []
    assert np.allclose(read(Path("c.npz")).points, head().reshape(-1, 3), atol=1e-5)


def test_convert_says_what_it_changed(run: Runner) -> None:
    edits = ["--min-length", "20", "--strands", "50", "--resample", "9"]
    words = run.fine("convert", "a.hair", "b.ply", *edits)
    assert words.out == ""
    assert "too short" in words.err
    assert "4,000 points" not in words.err
    assert "largest deviation" in words.err
    data = json.loads(run("convert", "a.hair", "b.ply", "--simplify", "0.1", "--json", "--overwrite").out)
    assert data["edits"][0]["deviation_max"] <= 0.1
    assert data["points"] == read(Path("b.ply")).points.shape[0] < 4000
    assert run("convert", "a.hair", "b.data", "-q").err == ""


@pytest.mark.parametrize(("arguments", "code", "message"), [
    (("a.hair", "b.png"), 2, "let the name end in one of .hair, "),
    (("a.hair", "a.hair"), 2, "is there already; add --overwrite"),
    (("none.hair", "b.ply"), 2, "none.hair: no such file"),
    (("a.hair", "b.ply", "--resample", "2", "--simplify", ".1"), 2, "--resample and --simplify exclude each other"),
    (("a.hair", "b.ply", "--scale", "0"), 2, "--scale"),
    (("a.hair", "b.ply", "--scale", "1e38"), 2, "too far out for single precision"),
    (("a.hair", "b.ply", "--to-up", "z"), 2, "--up as well"),
    (("a.hair", "none/b.ply"), 4, "cannot be written"),
    (("/dev/zero", "b.ply"), 2, "no file but a pipe or a device"),
])  # fmt: skip
def test_faults_are_one_line(run: Runner, arguments: tuple[str, ...], code: int, message: str) -> None:
    assert message in run.refused("convert", *arguments, code=code)
    assert not Path("b.ply").exists()


def test_a_file_that_is_its_own_target_is_whole(run: Runner) -> None:
    assert run("convert", "a.hair", "a.hair", "--strands", "100", "--overwrite").code == 0
    assert read(Path("a.hair")).count == 100
