"""Every program of examples/ runs as its page says: here, or where what it makes is looked at."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from PIL import Image

from cli_runs import ROOT, environment

EXAMPLES = ROOT / "examples"
PICTURES = {
    "vortex_rule.py": ("vortex", "vortex/vortex_12.png"), "shadow_model.py": ("mist", "mist/frame_0001.png"),
    "fibre_model.py": ("kajiya", "kajiya/frame_0001.png"), "solid_shape.py": ("ring.png", "ring.png"),
}  # fmt: skip
"""What follows the program, and a picture that it draws."""
ELSEWHERE = {"dataset.py": "test_dataset.py", "against_pyelastica.py": "test_pyelastica.py"}


def run(folder: Path, program: str, *words: str) -> str:
    """What a program prints that ends well."""
    command = [sys.executable, str(EXAMPLES / program), *words]
    done = subprocess.run(command, cwd=folder, env=environment(), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_each_program_is_run_by_a_test() -> None:
    there = {path.name for path in EXAMPLES.glob("*.py")}
    assert there == {*PICTURES, *ELSEWHERE, "guides.py"}
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
