"""Every program of examples/ runs as its page says: here, or where what it makes is looked at."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from cli_runs import ROOT, environment

EXAMPLES = ROOT / "examples"
PICTURES = {
    "vortex_rule.py": ("vortex", "vortex/vortex_12.png"), "shadow_model.py": ("mist", "mist/frame_0001.png"),
    "fibre_model.py": ("kajiya", "kajiya/frame_0001.png"), "solid_shape.py": ("ring.png", "ring.png"),
}  # fmt: skip
"""What follows the program, and a picture that it draws."""
ELSEWHERE = {"dataset.py": "test_dataset.py"}


def run(folder: Path, program: str, *words: str) -> str:
    """What a program prints that ends well."""
    command = [sys.executable, str(EXAMPLES / program), *words]
    done = subprocess.run(command, cwd=folder, env=environment(), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_each_program_is_run_by_a_test() -> None:
    there = {path.name for path in EXAMPLES.glob("*.py")}
    assert there == {*PICTURES, *ELSEWHERE, "guides.py", SCRIPT.name}
    for program, test in ELSEWHERE.items():
        assert program in Path(__file__).with_name(test).read_text(encoding="utf-8")
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


SCRIPT = Path(__file__).resolve().parents[2] / "examples" / "against_pyelastica.py"


@pytest.fixture(scope="module")
def example() -> Any:
    spec = importlib.util.spec_from_file_location("against_pyelastica", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["against_pyelastica"] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


def test_without_pyelastica_one_line_says_what_to_install(
    example: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "elastica", None)
    assert example.main([]) == 1
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err == "PyElastica is not installed here: pip install pyelastica\n"


def test_a_strand_comes_to_rest_near_the_elastica_and_nearer_with_more_segments(example: Any) -> None:
    few, more = (example.of_strandcli(10.0, segments, 3) for segments in (9, 18))
    assert few.error == pytest.approx(0.0102, rel=0.05)
    assert 3.5 < few.error / more.error < 4.5
    assert few.seconds > 0
    assert example.off((0.0, 0.0, 0.0), 10.0) == pytest.approx(0.958, abs=0.002)


def test_a_step_is_stable_where_the_next_smaller_one_agrees(example: Any) -> None:
    def run(step: float, error: float) -> Any:
        return example.Run("PyElastica", 10, step, 1, error, 1.0)

    wild, coarse, fine = run(0.4, float("nan")), run(0.3, 0.004), run(0.2, 0.00401)
    assert example.settled([wild, coarse, fine]) is coarse
    assert example.settled([wild, coarse]) is None
