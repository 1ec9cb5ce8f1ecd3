"""What is planned is what is run; too much is refused before anything is allocated."""

from __future__ import annotations

import dataclasses
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from plan_figures import measured
from strand_kit import frames_of, scene_of, solver_of
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.shadows.shadow import plan_maps
from strandcli.errors import RefusedError
from strandcli.plan import Plan, available_memory, checked_plan, limits, make_plan, needed_strands, needs_shadow_maps
from strandcli.plan import make as making
from strandcli.plan import require as planning
from strandcli.scene import Scene
from strandcli.simulate import compose
from tests.run.test_pipeline_extremes import EVERYTHING, UNLIT

BOUNDS = np.array([[-1.0, -1, -1], [1, 1, 1]])


def stages(plan: Plan) -> tuple[dict[str, str], dict[str, str]]:
    return {one.stage: one.why for one in plan.used}, {one.stage: one.why for one in plan.left_out}


def test_planning_imports_neither_numpy_nor_numba() -> None:
    code = f"""
import sys
from strandcli.scene import loads
from strandcli.simulate.rules import registry
from strandcli.plan import make_plan, require_memory
scene = loads({EVERYTHING!r}, rules=registry())
require_memory(make_plan(scene, range(1, 4)), scene, range(1, 4))
print(*sorted({{"numpy", "numba", "PIL", "platformdirs"}} & {{name.split(".")[0] for name in sys.modules}}))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


def test_counts() -> None:
    plan = make_plan(scene_of(EVERYTHING + "curves: {level: 3}\n"), [1, 2, 6])
    assert (plan.strands, plan.particles, plan.frames) == (80, 400, 3)
    assert plan.steps == 5
    assert plan.segments_max == 80 * 4 * 8
    assert (plan.pixels, plan.samples) == (40 * 32, 40 * 32)
    scene = scene_of(UNLIT + "time: {fps: 10, substeps: 4, preroll: 0.55}\ncurves: {mode: 'off'}\n")
    assert make_plan(scene, [3]).steps == 22 + 8
    assert make_plan(scene, [3]).segments_max == 20 * 2
    assert make_plan(scene_of(UNLIT.replace("[elasticity]", "[]")), [9]).steps == 0


def test_children_are_counted_with_their_steps() -> None:
    text = EVERYTHING + "curves: {level: 1}\n"
    waves = "children: {count: 5, waves: [{length: 0.1}]}\n"
    plain, few, many = (make_plan(scene_of(text + more), [1]) for more in ("", waves, waves.replace("5", "5000")))
    assert few.strands == plain.strands == 80
    scene = scene_of(text + waves)
    from strandcli.groom.children import Children
    from strandcli.groom.emit import emit

    steps = Children(scene, emit(scene.emitter, scene.seed)).steps
    assert steps > 1
    assert few.segments_max == 5 * 80 * 4 * steps * 2
    assert "children" in stages(few)[0]
    assert "children" in stages(plain)[1]
    # positions of the finer strands alone take 12 bytes a particle
    assert many.memory_bytes - few.memory_bytes > 4995 * 80 * 12 * (4 * steps + 1)


@pytest.mark.parametrize("preroll", [0.0, 0.24, 0.25, 0.26, 1.0])
def test_steps_are_those_that_the_solver_takes(preroll: float) -> None:
    scene = scene_of(UNLIT + f"time: {{fps: 10, substeps: 2, preroll: {preroll}}}\n")
    solver = solver_of(scene, plain=True)
    taken: list[float] = []
    solver.step = lambda time, dt: taken.append(time)  # type: ignore[method-assign]
    solver.advance(4)
    assert len(taken) == make_plan(scene, [4]).steps
    assert taken[-1] == pytest.approx(0.3)
    np.testing.assert_allclose(np.diff(taken), 0.05)


def test_a_frame_has_no_more_segments_than_planned() -> None:
    for text in (EVERYTHING, UNLIT, UNLIT + "curves: {mode: fixed, level: 3}\n", UNLIT + "curves: {mode: 'off'}\n"):
        scene = scene_of(text)
        (frame,) = frames_of(scene, 1)
        assert 0 < frame.report["counts"]["segments"] <= make_plan(scene, [1]).segments_max
    assert frames_of(scene_of(UNLIT + "curves: {mode: fixed}\n"), 1)[0].report["counts"]["segments"] == 20 * 2 * 4


@pytest.mark.parametrize(
    "rules",
    [
        "",
        "gravity, elasticity",
        "emitter_motion, gravity: {acceleration: [0, 0, 0]}, wind: {strength: 0}, stiffness: {strength: 0}, elasticity",
        "emitter_motion, gravity, wind, stiffness, collision, elasticity",
    ],
)
@pytest.mark.parametrize("text", [EVERYTHING, UNLIT])
def test_rules_that_are_planned_are_those_that_are_composed(rules: str, text: str) -> None:
    head, _, tail = text.partition("rules:")
    rest = tail[tail.index("camera:" if "camera:" in tail else "emitter:") :]
    scene = scene_of(f"{head}{rest}rules: [{rules}]\n")
    used, left = stages(make_plan(scene, [1]))
    composed = compose.source(solver_of(scene, plain=True).passes)
    for name in ("emitter_motion", "gravity", "wind", "stiffness", "collision", "elasticity"):
        assert (f"rule {name}" in used) != (f"rule {name}" in left)
        room = "solids.kernels." if name == "collision" else f"rules.{name}"
        assert (f"rule {name}" in used) == (room in composed)
    if "gravity:" in rules:
        assert left["rule gravity"] == "its acceleration is zero"
    if not rules:
        assert left["rule wind"] == "the preset does not list it"
        assert ("emitter keys" in left) == (len(scene.emitter.keys) > 1)


def shadowless(text: str) -> Scene:
    return scene_of(text.replace("shadow: {size: 64}", "shadow: {model: 'off'}"))


@pytest.mark.parametrize(
    ("scene", "wanted"),
    [
        (scene_of(EVERYTHING), True),
        (shadowless(EVERYTHING), False),
        (scene_of(EVERYTHING[: EVERYTHING.index("lights:")] + "lights: []\n"), False),
        (scene_of(UNLIT + "lights: [{kind: point, intensity: 0}]\n"), False),
        (scene_of(UNLIT + "lights: [{kind: point, colour: [0, 0, 0]}, {kind: directional}]\n"), True),
    ],
)
def test_shadow_maps_are_planned_where_they_are_made(scene: Scene, wanted: bool) -> None:
    used, left = stages(make_plan(scene, [1]))
    assert ("shadow maps" in used, "shadow maps" in left) == (wanted, not wanted)
    assert needs_shadow_maps(scene) == wanted
    assert (plan_maps(scene.lights, BOUNDS, Scratch()) is not None) == wanted


def test_reasons_are_told() -> None:
    used, left = stages(make_plan(scene_of(UNLIT), [1]))
    assert left["marschner tables"] == "material.specular is zero"
    assert left["solids"] == "there are none to see"
    assert left["level of detail"] == "the preset has none"
    assert left["pre-roll"] == "its time is zero"
    assert left["supersampling"] == "one sample a pixel"
    assert used["curves"] == "within 0.25 px, with at most 4 pieces a segment"
    text = UNLIT.replace("size: [20, 16]", "size: [20, 16], supersample: 3") + "time: {preroll: 2}\nlights: []\n"
    used, left = stages(make_plan(scene_of(text + "curves: {mode: 'off'}\n"), [1]))
    assert left["curves"] == "the preset draws straight segments"
    assert left["marschner tables"] == "there is no light"
    assert used["pre-roll"] == "2 s, 48 steps before frame 1"
    assert used["supersampling"] == "3 x 3 samples a pixel"


def test_panels_add_up() -> None:
    one = make_plan(scene_of(UNLIT), [1, 2])
    text = UNLIT + "panels: [{label: a}, {label: b, set: {emitter.strands: 60}}, {set: {rules: []}}]\n"
    three = make_plan(scene_of(text), [1, 2])
    assert three.frames == 2
    assert three.strands == 20 + 60 + 20
    assert three.steps == 2 * one.steps
    assert three.pixels == 3 * one.pixels
    assert one.memory_bytes < three.memory_bytes < 3 * one.memory_bytes
    used, left = stages(three)
    assert "a: rule elasticity" in used
    assert "panel: rule elasticity" in left


def bytes_of(strands: int = 80, particles: int = 5, size: int = 40, draw: bool = True) -> int:
    text = EVERYTHING.replace("strands: 80", f"strands: {strands}").replace("particles: 5", f"particles: {particles}")
    return make_plan(scene_of(text.replace("[40, 32]", f"[{size}, 32]")), [1], draw).memory_bytes


def test_memory_grows_with_what_takes_it() -> None:
    small = bytes_of()
    assert small < 300e6
    # positions alone: 12 bytes a particle, packed and unpacked
    assert bytes_of(1_000_000, 10, draw=False) > small + 24 * 10_000_000
    assert bytes_of(1_000_000, 10) > bytes_of(1_000_000, 10, draw=False)
    assert bytes_of(1_000_000, 10) < 4e9
    assert bytes_of(10_000, 10, 800) < 500e6
    # pictures: a key of 8 bytes and three colours of 4 bytes a sample
    assert bytes_of(size=30_000) - small > 20 * 30_000 * 31


def test_level_of_detail_saves_memory_only_where_frames_are_drawn() -> None:
    far = EVERYTHING.replace("strands: 80", "strands: 1000000") + "detail: {near: 0.1, fraction: 0.01}\n"
    drawn, simulated = make_plan(scene_of(far), [1]), make_plan(scene_of(far), [1], draw=False)
    assert drawn.strands < 50_000
    assert simulated.strands == 1_000_000
    assert simulated.memory_bytes > drawn.memory_bytes


def test_all_strands_move_where_they_act_on_each_other_however_few_are_drawn() -> None:
    far = "solver: rod\nemitter: {strands: 3000}\ndetail: {near: 0.1, fraction: 0.01}\ncamera: {position: [0, 0, 50]}\n"
    assert needed_strands(scene_of(far + "rules: [gravity]\n"), [1]) < 1000
    assert needed_strands(scene_of(far + "rules: [gravity, interaction]\n"), [1]) == 3000


def test_more_than_four_fifths_of_what_is_free_is_refused_with_what_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = scene_of(EVERYTHING.replace("strands: 80", "strands: 2000000").replace("[40, 32]", "[4000, 3200]"))
    plan = make_plan(scene, [1])
    free = [plan.memory_bytes / 0.8, None, plan.memory_bytes / 0.8 - 2]
    monkeypatch.setattr(planning, "available_memory", lambda: free.pop(0))
    checked_plan(scene, [1])
    checked_plan(scene, [1])  # nobody tells
    with pytest.raises(RefusedError, match=r"more than 80 % of the \d\.\d GB that are free: take") as caught:
        checked_plan(scene, [1])
    assert caught.value.exit_code == 4
    assert "--no-memory-check" not in str(caught.value)
    found = re.search(r"--strands (\d+) \(about ([\d.]+) GB\) or --size (\d+)x(\d+) \(", str(caught.value))
    assert found is not None
    fewer = dataclasses.replace(scene, emitter=dataclasses.replace(scene.emitter, strands=int(found[1])))
    assert make_plan(fewer, [1]).memory_bytes < plan.memory_bytes
    assert make_plan(fewer, [1]).memory_bytes == pytest.approx(float(found[2]) * 1e9, abs=0.06e9)
    size = (int(found[3]), int(found[4]))
    smaller = dataclasses.replace(scene, image=dataclasses.replace(scene.image, size=size))
    assert make_plan(smaller, [1]).memory_bytes < plan.memory_bytes
    free[:] = [10**6]
    checked_plan(scene, [1], check=False)
    with pytest.raises(RefusedError, match="--no-memory-check goes on all the same"):
        checked_plan(scene, [1], check=True)


@pytest.mark.parametrize("version", [1, 2])
def test_a_control_group_that_has_less_left_than_the_machine_refuses(
    version: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    group, told = tmp_path / ("memory" if version == 1 else "") / "user.slice" / "job", tmp_path / "told"
    group.mkdir(parents=True)
    names = ("memory.limit_in_bytes", "memory.usage_in_bytes") if version == 1 else ("memory.max", "memory.current")
    for folder, numbers in ((group, (2**63 - 4096, 0)), (group.parent, (300_000_000, 90_000_000))):
        for name, number in zip(names, numbers, strict=True):
            (folder / name).write_text(f"{number}\n")
    told.write_text("9:cpu,memory:/user.slice/job\n" if version == 1 else "0::/user.slice/job\n")
    left = limits.memory_left
    monkeypatch.setattr(limits, "memory_left", lambda: left(tmp_path, told))
    assert available_memory() == 210_000_000
    with pytest.raises(RefusedError, match="more than 80 % of the 210 MB that are free"):
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


def test_free_memory_is_known_here() -> None:
    free = available_memory()
    if Path("/proc/meminfo").exists():
        assert free is not None
        assert 2**20 < free < 2**50


@pytest.mark.parametrize(
    "setting", ["emitter.strands=100000000", "image.size=[32768, 32768]", "emitter.particles=90000"]
)
@pytest.mark.parametrize("command", ["render", "simulate"])
def test_a_run_too_large_for_any_memory_is_refused_before_numpy_is_imported(
    setting: str, command: str, tmp_path: Path
) -> None:
    if command == "simulate" and "size" in setting:
        return
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
    if sys.platform == "win32":
        pytest.skip("measured by wait4")
    found = measured(("minimal", "--size", "320x240", "-f", "1"), tmp_path, timed=False)
    assert found.within(), f"{found.planned / 1e6:.0f} MB planned, {found.peak / 1e6:.0f} MB measured"


def test_planning_millions_of_strands_makes_few_of_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Half a minute and 3 GB once went by for the warnings of 11 million."""
    from strandcli.cli import plan
    from strandcli.cli.main import main
    from strandcli.groom import emit

    made: list[int] = []
    whole = emit.emit
    monkeypatch.setattr(emit, "emit", lambda *given: made.append(given[2]) or whole(given[0], given[1], 5))
    preset = tmp_path / "many.yaml"
    preset.write_text("emitter: {strands: 11000000, particles: 2}\nimage: {size: [8, 8]}\nrules: [gravity]\n")
    assert main(["plan", str(preset)]) == 0
    assert made == [plan.LOOKED_AT]
    assert "11,000,000 strands" in capsys.readouterr().out
