"""Bad input: refused by name and place, or told before the run where the run makes sense all the same."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import strandcli
from cli_runs import Runner
from strand_kit import groom_of, scene_of, warned
from strandcli.errors import UsageError
from strandcli.groom.emit import emit
from strandcli.simulate import advice, rules
from strandcli.simulate.rod.solver import RodSolver
from strandcli.simulate.thesis.solver import ThesisSolver


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("twist: 1", "how much strands resist it is torsion"),
        ("mass: 1", "mass follows from density and radius"),
        ("stiffness: 3", "young and radius"),
        ("yung: 3", "did you mean 'young'?"),
    ],
)
def test_what_rods_do_not_have_is_said_where_it_is_asked_for(run: Runner, key: str, words: str) -> None:
    Path("p.yaml").write_text(f"solver: rod\nrod:\n  {key}\n")
    result = run.refused("plan", "p.yaml")
    assert result.startswith(f"p.yaml:3:3: rod.{key.split(':')[0]}: ")
    assert words in result


def test_a_rule_that_rods_do_not_apply_is_refused_where_it_stands(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    import bad_rules

    monkeypatch.setitem(rules._registry, "rooted", bad_rules.rooted)
    Path("p.yaml").write_text("solver: rod\nrules:\n- gravity\n- rooted: {after: 1}\n- elasticity\n")
    line = run("plan", "p.yaml").error()
    assert line.startswith("p.yaml:4:11: rooted: the solver rod does not apply this rule, only emitter_motion, gravity")
    Path("q.yaml").write_text("rules: [rooted]\npanels: [{label: a}, {label: b, set: {solver: rod}}]\n")
    assert run("plan", "q.yaml").error().startswith("q.yaml:2:22: panels.1.set.rooted: the solver rod does not")
    assert run("plan", "p.yaml", "--set", "solver=thesis").code == 0


def test_rods_take_a_preset_of_the_source_and_say_what_they_leave_out() -> None:
    (words,) = warned("solver: rod\nrules: [gravity, stiffness, elasticity]\nemitter: {strands: 3}\n")
    assert words.startswith("rule stiffness: ignored, rods bend by their material")
    assert warned("solver: rod\nrules: [stiffness: {strength: 0}]\nemitter: {strands: 3}\n") == []


@pytest.mark.parametrize("solver", [RodSolver, ThesisSolver])
def test_a_groom_is_refused_with_how_many_of_its_strands_are_bad(solver: type) -> None:
    scene = scene_of("emitter: {strands: 5, particles: 3}\nrules: [gravity]\n")
    groom = emit(scene.emitter, 0)
    groom.lengths[[2, 4]] = 0
    with pytest.raises(UsageError, match=r"^groom: strand 2: its length is not positive.*\(2 such strands\)"):
        solver(scene, groom)


SOLIDS = {
    "sphere": ("{kind: sphere, radius: 3}", 2.0),
    "capsule": ("{kind: capsule, radius: 2, length: 4}", 2.0),
    "box": ("{kind: box, size: [6, 8, 8], rotation: [0, 0, 90]}", 3.0),
    "plane": ("{kind: plane, position: [0, 2, 0]}", 3.0),
}


@pytest.mark.parametrize("kind", SOLIDS)
def test_a_solid_that_swallows_roots_is_named_with_how_many(kind: str) -> None:
    solid, deepest = SOLIDS[kind]
    text = "emitter: {strands: 200, particles: 5}\nrules: [collision: {with: [SOME]}]\nsolids: [BALL, OTHER]\n"
    far = "{kind: sphere, name: far, position: [9, 9, 9]}"
    text = text.replace("BALL", solid.replace("}", ", name: it}")).replace("OTHER", far)
    scene = scene_of(text.replace("SOME", "it, far"))
    (words,) = warned(scene)
    depths = advice.depth(groom_of(scene).roots.astype(np.float64), scene.solids[0], scene.emitter)
    count = int((depths > 0.25).sum())
    assert words.startswith(f"solids.0 (it): swallows the roots of {count} of 200 strands, up to ")
    assert deepest - 0.15 < depths.max() < deepest + 1e-6  # the deepest of 200 roots spread over the sphere
    assert warned(text.replace("SOME", "far")) == []


LATER = """
time: {frames: 12, fps: 24}
emitter: {strands: 300, particles: 5, shape: {kind: sphere, radius: 0.1}, length: 0.2KEYS}
rules: [RULES, gravity, collision]
solids: [{kind: sphere, name: ball, radius: 0.15, KEYED}]
"""
COMES = "keys: [{time: 0, position: [2, 0, 0], ease: step}, {time: 0.2, position: [0.1, 0, 0]}]"


def advised(keys: str, rules: str, keyed: str) -> list[str]:
    return warned(LATER.replace("KEYS", keys).replace("RULES", rules).replace("KEYED", keyed))


def test_a_solid_that_comes_to_swallow_roots_is_named_with_its_frame() -> None:
    (words,) = advised("", "emitter_motion", COMES)
    assert words.startswith("solids.0 (ball): from frame 6 on swallows the roots of ")
    moved = ", keys: [{time: 0}, {time: 0.5, position: [1, 0, 0]}]"
    still = "position: [0.95, 0, 0]"
    (words,) = advised(moved, "emitter_motion", still)
    assert words.startswith("solids.0 (ball): from frame ")
    assert advised(moved, "stiffness", still) == []  # no rule carries the roots there
    assert advised(moved, "emitter_motion", still + ", follow: emitter") == []
    assert advised("", "emitter_motion", COMES.replace("[0.1, 0, 0]", "[1.5, 0, 0]")) == []


def test_plan_warns_as_render_does_and_imports_no_numba(run: Runner) -> None:
    text = LATER.replace("KEYS", "").replace("RULES", "emitter_motion").replace("KEYED", COMES)
    Path("p.yaml").write_text(f"image: {{size: [24, 16]}}\n{text}")
    planned, drawn = run("plan", "p.yaml"), run("render", "p.yaml", "-f", "1", "-o", "a")
    lines = [line for line in planned.err.splitlines() if line.startswith("warning: ")]
    assert lines == [line for line in drawn.err.splitlines() if line.startswith("warning: ")] != []
    data = json.loads(run("plan", "p.yaml", "--json").out)
    assert [f"warning: {words}" for words in data["warnings"]] == lines
    script = "import sys; from strandcli.cli.main import main\n"
    script += "try: main(['plan', 'p.yaml'])\nexcept SystemExit: pass\nassert 'numba' not in sys.modules"
    subprocess.run([sys.executable, "-c", script], check=True, capture_output=True)


@pytest.mark.parametrize("kind", SOLIDS)
def test_depths_are_distances_to_the_surface(kind: str) -> None:
    """Against the depth that frames report, of which particles' is measured and roots' is not."""
    scene = scene_of(f"emitter: {{strands: 60, particles: 3}}\nrules: [collision]\nsolids: [{SOLIDS[kind][0]}]\n")
    solver = ThesisSolver(scene, groom_of(scene))
    points = solver.particles()[:, 1:].reshape(-1, 3).astype(np.float64)
    most = max(float(advice.depth(points, scene.solids[0], scene.emitter).max()), 0)
    assert solver.errors(1)["penetration_max"] == pytest.approx(most, abs=1e-5)


def test_a_ball_smaller_than_a_segment_is_named_unless_segments_are_looked_at() -> None:
    text = "emitter: {strands: 9, particles: 3}\nrules: [collision: {segments: SEG}]\n"
    text += "solids: [{kind: sphere, name: pea, radius: 0.2, position: [0, 3, 0]}]\n"
    (words,) = warned(text.replace("SEG", "false"))
    assert words.startswith("solids.0 (pea): its radius of 0.2 m is less than half a segment of 0.5 m")
    assert warned(text.replace("SEG", "true")) == []
    assert warned(text.replace("SEG", "false").replace("0.2", "0.3")) == []


@pytest.mark.parametrize(
    ("solver", "rules", "advice_given"),
    [
        ("thesis", "elasticity, collision", "set collision.segments: true, or use more emitter.particles"),
        ("thesis", "collision, elasticity", "list collision last (what comes after it, elasticity, moves"),
        ("thesis", "collision, gravity, elasticity", "list collision last (what comes after it, gravity and"),
        ("thesis", "collision, emitter_motion", "set collision.segments: true, or use more emitter.particles"),
        ("rod", "collision, gravity", "set collision.segments: true, or use more emitter.particles"),
    ],
)
def test_segments_are_advised_where_nothing_comes_after_collision(solver: str, rules: str, advice_given: str) -> None:
    text = f"solver: {solver}\nemitter: {{strands: 9, particles: 3}}\nrules: [{rules}]\n"
    (words,) = warned(text + "solids: [{kind: sphere, radius: 0.2, position: [0, 3, 0]}]\n")
    assert f"unnoticed; {advice_given}" in words


def test_a_single_root_that_is_held_to_the_end_is_told_and_one_that_is_set_free_is_not() -> None:
    """A thin ball, in which one of 300 roots stays, or has been."""
    scene = scene_of(LATER.replace("KEYS", "").replace("RULES", "emitter_motion").replace("KEYED", COMES))
    root = groom_of(scene).roots[7]
    away = "{time: 0, position: [2, 0, 0], ease: step}"
    there = f"time: 0.2, position: [{root[0]}, {root[1]}, {root[2]}], ease: step"
    text = LATER.replace("radius: 0.15", "radius: 0.0501").replace("KEYS", "").replace("RULES", "emitter_motion")
    (words,) = (words for words in warned(text.replace("KEYED", f"keys: [{away}, {{{there}}}]")) if "swallows" in words)
    assert words.startswith("solids.0 (ball): from frame 6 on swallows the roots of 1 of 300 strands")
    leaves = "{time: 0.4, position: [2, 0, 0], ease: step}"
    assert "swallows" not in str(warned(text.replace("KEYED", f"keys: [{away}, {{{there}}}, {leaves}]")))


def test_strands_too_far_away_for_single_precision_are_told() -> None:
    text = "emitter: {strands: 9, particles: 11, position: [0, -FAR, 5]}\n"
    (words,) = warned(text.replace("FAR", "1000000"))
    assert words.startswith("strands are 1e+06 m from the origin, where places are rounded to 0.062 m, 62 % of a segm")
    assert warned(text.replace("FAR", "1000")) == []


@pytest.mark.parametrize("solver", ["rod", "thesis"])
def test_a_run_goes_on_with_its_roots_swallowed_and_says_so(run: Runner, solver: str) -> None:
    Path("p.yaml").write_text(
        f"solver: {solver}\ntime: {{frames: 3}}\nimage: {{size: [24, 16]}}\nemitter: {{strands: 40, particles: 4}}\n"
        "solids: [{kind: sphere, name: head, radius: 3}]\nrules: [gravity, collision, elasticity]\n"
    )
    result = run.fine("render", "p.yaml", "-o", "a")
    assert "warning: solids.0 (head): swallows the roots of 40 of 40 strands" in result.err
    data = json.loads(Path("a/report.json").read_text())
    assert "swallows" in data["warnings"][0]
    assert all(entry["error"]["nonfinite"] == 0 and entry["error"]["penetration_max"] > 1 for entry in data["frames"])


@pytest.mark.parametrize("preset", ["hair", "fur", "headline", "minimal", "grass", "ponytail"])
def test_shipped_presets_need_no_advice(preset: str) -> None:
    assert warned(strandcli.load(preset, settings={"emitter.strands": 500})) == []
