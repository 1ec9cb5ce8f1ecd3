"""The memory that a run is planned to take, and what is refused because of it."""

from __future__ import annotations

import dataclasses
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from plan_figures import measured
from rod_kit import rod_of
from strand_kit import scene_of
from strandcli.common import limits
from strandcli.errors import RefusedError
from strandcli.groom.blocks import arranged
from strandcli.groom.emit import emit
from strandcli.plan import available_memory, checked_plan, make_plan
from strandcli.plan import make as making
from strandcli.plan.sizes import grid_bytes
from strandcli.simulate.rod import needs_double, shortest_segment
from strandcli.simulate.rod.solver import RodSolver
from tests.run.test_pipeline_extremes import EVERYTHING
from tests.simulate.test_grid import BALL


@pytest.mark.parametrize(
    ("rod", "particles", "more", "double"),
    [
        ("", 100, "", False),
        ("rest: sag_free", 20, "", False), ("rest: sag_free", 21, "", True),
        ("tip: 0.05", 10, "", False), ("tip: 0.05", 100, "", True),
        ("", 20, ", length_variation: 0.999999", False), ("", 20, ", length: 1e-4", True),
    ],
)  # fmt: skip
def test_rods_are_planned_in_the_precision_they_are_solved_in(
    rod: str, particles: int, more: str, double: bool
) -> None:
    """Double for long sag-free strands, by how rigidities differ, and by deep falls."""
    fall = "[0, -1e4, 0]" if "1e-4" in more else "[0, -9.81, 0]"
    scene = scene_of(
        f"solver: rod\nrod: {{{rod}}}\nrules: [gravity: {{acceleration: {fall}}}]\n"
        f"emitter: {{strands: 2048, particles: {particles}{more}}}\n"
    )
    solver = RodSolver(scene, emit(scene.emitter, scene.seed))
    assert (solver.dtype == np.float64) == double
    assert needs_double(scene, shortest_segment(scene.emitter)) == double


def test_level_of_detail_saves_memory_only_where_frames_are_drawn() -> None:
    far = EVERYTHING.replace("strands: 80", "strands: 1000000") + "detail: {near: 0.1, fraction: 0.01}\n"
    drawn, simulated = make_plan(scene_of(far), [1]), make_plan(scene_of(far), [1], draw=False)
    assert drawn.strands < 50_000
    assert simulated.strands == 1_000_000
    assert simulated.memory_bytes > drawn.memory_bytes


def test_more_than_four_fifths_of_what_is_free_is_refused_with_what_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = scene_of(EVERYTHING.replace("strands: 80", "strands: 2000000").replace("[40, 32]", "[4000, 3200]"))
    plan = make_plan(scene, [1])
    free = [plan.memory_bytes / 0.8, None, plan.memory_bytes / 0.8 - 2]
    monkeypatch.setattr(making, "available_memory", lambda: free.pop(0))
    checked_plan(scene, [1])
    checked_plan(scene, [1])  # nobody tells
    with pytest.raises(RefusedError, match=r"more than 80 % of the \d\.\d GB that are free: take") as caught:
        checked_plan(scene, [1])
    assert caught.value.exit_code == 4
    assert "--no-memory-check" not in str(caught.value)
    found = re.search(r"--strands (\d+) \(about ([\d.]+) GB\) or --size (\d+)x(\d+) \(", str(caught.value))
    fewer = dataclasses.replace(scene, emitter=dataclasses.replace(scene.emitter, strands=int(found[1])))
    assert make_plan(fewer, [1]).memory_bytes < plan.memory_bytes
    assert make_plan(fewer, [1]).memory_bytes == pytest.approx(float(found[2]) * 1e9, abs=0.06e9)
    size = (int(found[3]), int(found[4]))
    smaller = dataclasses.replace(scene, image=dataclasses.replace(scene.image, size=size))
    assert make_plan(smaller, [1]).memory_bytes < plan.memory_bytes
    free[:] = [10**6]
    checked_plan(scene, [1], check=False)
    with pytest.raises(RefusedError, match="--no-memory-check runs it anyway"):
        checked_plan(scene, [1], check=True)


@pytest.mark.parametrize("version", [1, 2])
def test_a_control_group_that_has_less_left_than_the_machine_refuses(
    version: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    group, told = tmp_path / ("memory" if version == 1 else "") / "user.slice" / "job", tmp_path / "told"
    group.mkdir(parents=True)
    names = ("memory.limit_in_bytes", "memory.usage_in_bytes") if version == 1 else ("memory.max", "memory.current")
    for folder, numbers in ((group, (2**63 - 4096, 0)), (group.parent, (200_000_000, 90_000_000))):
        for name, number in zip(names, numbers, strict=True):
            (folder / name).write_text(f"{number}\n")
    told.write_text("9:cpu,memory:/user.slice/job\n" if version == 1 else "0::/user.slice/job\n")
    left = limits.memory_left
    monkeypatch.setattr(limits, "memory_left", lambda: left(tmp_path, told))
    assert available_memory() == 110_000_000
    with pytest.raises(RefusedError, match="more than 80 % of the 110 MB that are free"):
        checked_plan(scene_of(EVERYTHING), [1])


def test_frames_at_once_take_no_more_than_is_free(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = scene_of(EVERYTHING.replace("[40, 32]", "[4000, 3200]"))
    alone = make_plan(scene, range(1, 9))
    for spare, at_once in ((1e12, 4), (1.5, 1)):
        monkeypatch.setattr(making, "available_memory", lambda times=spare: int(times * alone.memory_bytes))
        plan = make_plan(scene, range(1, 9), threads=4)
        assert plan.memory_bytes == alone.memory_bytes
        assert plan.frames_at_once <= at_once
        assert plan.memory_at_once_bytes <= max(alone.memory_bytes, 0.8 * spare * alone.memory_bytes)
    assert make_plan(scene, [1, 2], threads=4).frames_at_once == 1


@pytest.mark.parametrize(
    ("command", "setting"), [("render", "image.size=[32768, 32768]"), ("simulate", "emitter.strands=100000000")]
)
def test_a_run_too_large_for_any_memory_is_refused_before_numpy_is_imported(
    setting: str, command: str, tmp_path: Path
) -> None:
    preset = tmp_path / "large.yaml"
    text = EVERYTHING.replace("length: 0.8", "length: 1000000").replace("particles: 5", "particles: 500")
    preset.write_text(text.replace("strands: 80", "strands: 1000000"), encoding="utf-8")
    code = f"""
import sys
from strandcli.cli.main import main
settings = ["--set", {setting!r}, "--set", "image.supersample=8"]
status = main([{command!r}, {str(preset)!r}, "-o", {str(tmp_path / "out")!r}, *settings])
assert "numpy" not in sys.modules
raise SystemExit(status)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 4, done.stderr
    assert "GB that are free: " in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.long
def test_memory_is_what_a_run_takes(tmp_path: Path) -> None:
    """A slice of `make plan-figures`. Of LLVM's library, which is a file in memory, the system maps 40 MB or 100,
    as it holds the file in pages or in larger pieces: a fifth of this small run."""
    found = measured(("minimal", "--size", "320x240", "-f", "1"), tmp_path, timed=False)
    assert found.within(), f"{found.planned / 1e6:.0f} MB planned, {found.peak / 1e6:.0f} MB measured"


TEXT = f"emitter: {{{BALL}, strands: 900}}\nrules: [gravity, interaction: {{density: 3000, cell: %s}}]"


def test_fine_cells_are_counted_as_the_solver_takes_them() -> None:
    """All but what arrays have in reserve, a fifth; parts of a ball reach other shares of its box
    than those of a head, by which bytes a cell were measured."""
    scene = rod_of(TEXT % 0.005).scene
    solver = RodSolver(scene, arranged(emit(scene.emitter, scene.seed)))  # as runs have them
    solver.advance(2)
    taken = (solver.grid._cells.nbytes + solver.grid.memory.nbytes) / 1.2
    assert grid_bytes(solver.scene, 900) == pytest.approx(taken, rel=0.25)


def test_usual_cells_and_scenes_without_the_rule_are_not_counted() -> None:
    assert grid_bytes(rod_of(TEXT % 0.05).scene, 900) == 0
    assert grid_bytes(rod_of(f"emitter: {{{BALL}, strands: 900}}\nrules: [gravity]").scene, 900) == 0
