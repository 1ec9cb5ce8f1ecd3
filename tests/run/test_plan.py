"""What is planned is what is run; too much is refused before anything is allocated."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from strand_kit import frames_of, scene_of
from strandcli.draw.common.scratch import Scratch
from strandcli.draw.shadows.shadow import plan_maps
from strandcli.plan import Plan, make_plan, needs_shadow_maps
from strandcli.scene import Scene, load
from strandcli.simulate.rules import registry
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


def test_a_frame_has_no_more_segments_than_planned() -> None:
    for text in (EVERYTHING, UNLIT, UNLIT + "curves: {mode: fixed, level: 3}\n", UNLIT + "curves: {mode: 'off'}\n"):
        scene = scene_of(text)
        (frame,) = frames_of(scene, 1)
        assert 0 < frame.report["counts"]["segments"] <= make_plan(scene, [1]).segments_max
    assert frames_of(scene_of(UNLIT + "curves: {mode: fixed}\n"), 1)[0].report["counts"]["segments"] == 20 * 2 * 4


@pytest.mark.parametrize(
    ("scene", "wanted"),
    [
        (scene_of(EVERYTHING), True),
        (scene_of(EVERYTHING.replace("shadow: {size: 64}", "shadow: {model: 'off'}")), False),
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


def test_alpha_of_pictures_is_told_where_it_would_count(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    opaque = Image.new("RGBA", (4, 2), (9, 9, 9, 255))
    clear = Image.new("RGBA", (4, 2), (9, 9, 9, 254))
    palette = opaque.convert("P")
    palette.info["transparency"] = int(palette.getpixel((0, 0)))  # type: ignore[arg-type]
    for name, image in (("opaque", opaque), ("clear", clear), ("palette", palette), ("plain", opaque.convert("RGB"))):
        image.save(f"{name}.png")
    Path("torn.png").write_bytes(Path("clear.png").read_bytes()[:50])
    told = [
        make_plan(scene_of(f"environment: {{image: {name}.png}}\n"), [1]).warnings
        for name in ("opaque", "plain", "torn", "clear", "palette")
    ]
    assert told[:3] == [[], [], []]
    for (words,), name in zip(told[3:], ("clear", "palette"), strict=True):
        assert words.startswith("environment.image: ")
        assert f"{name}.png: its alpha is ignored; " in words


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


def test_children_that_level_of_detail_leaves_out_take_no_memory() -> None:
    """Of `grass` a third is drawn, 426,100 blades; of a mesh nobody knows how far it reaches."""
    plan = make_plan(load("grass", rules=registry()), [1])
    assert plan.sizes.strands == 1_200_000
    assert plan.sizes.made == pytest.approx(426_100, rel=0.15)
    draft = load("hair", rules=registry(), settings={"quality": "draft"})
    plan = make_plan(draft, [1])
    assert 0.3 < plan.sizes.made / plan.sizes.strands <= 1
