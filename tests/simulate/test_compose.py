"""The composed step: what is in it and in which order; rules from outside of the package."""

from __future__ import annotations

import importlib.util
import os
import py_compile
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest

import strandcli.simulate.rules as rules_module
from strand_kit import moved, scene_of, solver_of
from strandcli.errors import UsageError
from strandcli.simulate.rules import Pass, idle, register, registry
from strandcli.simulate.thesis import solver as thesis

SCENE = """
emitter: {strands: 3, particles: 4, length: 0.6}
solids: [{kind: sphere, radius: 0.9}, {kind: box, position: [0, -3, 0]}]
rules: [%s]
"""
RULE = '''
"""Lift: p_i' = p_i + a Δt² up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from strandcli.scene.fields import number
from strandcli.simulate.rules import Pass

name = "lift"
order = 15.0


@dataclass(frozen=True)
class Parameters:
    strength: float = number(1.0, low=0, unit="m/s²", doc="pull upward")


def apply(a, b, c, length, p):
    return a[0], a[1] + p[0], a[2]


def idle(parameters, scene):
    return "" if parameters.strength > 0 else "its strength is zero"


def passes(parameters, scene):
    return [Pass(apply, lambda moment: np.array([parameters.strength * moment.step**2], np.float32), "lane", 1)]
'''


def text_of(rules: str) -> str:
    return thesis.source(solver_of(scene_of(SCENE % rules), plain=True).passes)


def test_a_rule_that_is_not_listed_or_has_nothing_to_do_is_not_in_the_source() -> None:
    text = text_of("gravity, elasticity")
    for name in ("wind", "stiffness", "collision", "emitter_motion"):
        assert name not in text
    idle_ones = "gravity: {acceleration: [0, 0, 0]}, wind: {strength: 0}, stiffness: {strength: 0}, emitter_motion"
    text = text_of(f"{idle_ones}, elasticity")
    for name in ("gravity", "wind", "stiffness", "emitter_motion"):
        assert name not in text
    assert text_of("elasticity").count("pass_") == 2  # made, and called


def test_without_rules_nothing_is_composed_and_nothing_moves() -> None:
    scene = scene_of(SCENE % "")
    solver = solver_of(scene, plain=True)
    assert solver._step is None
    np.testing.assert_array_equal(moved(scene, 5), solver.particles())


def test_equal_scenes_share_one_module_whose_name_says_what_is_in_it(tmp_path: Path) -> None:
    passes = solver_of(scene_of(SCENE % "gravity, elasticity"), plain=True).passes
    thesis.step_for(tuple(passes), tmp_path)
    (written,) = tmp_path.glob("*.py")
    assert written.read_text(encoding="utf-8") == thesis.source(passes)
    stamp = written.stat().st_mtime_ns
    thesis._load.cache_clear()
    thesis.step_for(tuple(passes), tmp_path)
    assert [written] == list(tmp_path.glob("*.py"))
    assert written.stat().st_mtime_ns == stamp
    for broken in (b"broken", b"\xff\xfe\x80 no text", b""):  # by whatever: it is written anew
        written.write_bytes(broken)
        thesis._load.cache_clear()
        thesis.step_for(tuple(passes), tmp_path)
        assert written.read_text(encoding="utf-8") == thesis.source(passes)
    assert not list(tmp_path.glob("*.part"))
    bytecode = Path(importlib.util.cache_from_source(str(written)))
    py_compile.compile(str(written), str(bytecode))
    bytecode.write_bytes(bytecode.read_bytes()[:40])
    thesis._load.cache_clear()
    thesis.step_for(tuple(passes), tmp_path)


def test_only_functions_that_can_be_imported_are_composed() -> None:
    for function in (lambda *rows: None, Path.exists, _inner()):
        with pytest.raises(UsageError, match=r"must be a plain function of a module that can be imported"):
            thesis.source([Pass(function, lambda moment: None)])


def _inner():  # type: ignore[no-untyped-def]
    def hidden(*rows: object) -> None:
        """A closure's function."""

    return hidden


@pytest.fixture
def lift(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[object]:
    """A rule in a module outside of the package, registered for one test."""
    (tmp_path / "lift_rule.py").write_text(RULE, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    import lift_rule

    register(lift_rule)
    yield lift_rule
    del rules_module._registry["lift"]  # type: ignore[attr-defined]
    del sys.modules["lift_rule"]


def test_a_rule_from_outside_is_used_by_a_preset(lift: object) -> None:
    scene = scene_of(SCENE % "lift: {strength: 24}")
    still = moved(scene, 1)
    for plain in (True, False):
        way = (moved(scene, 4, plain=plain) - still)[:, 1:]
        np.testing.assert_allclose(way, np.broadcast_to([0, 3 * 24 / 24**2, 0], way.shape), atol=1e-6)
    assert idle(scene_of(SCENE % "lift: {strength: 0}").rules[0], scene) == "its strength is zero"
    names = (
        "elasticity: {}, collision: {}, stiffness: {}, lift: {strength: 2}, wind: {}, gravity: {}, emitter_motion: {}"
    )
    order = "emitter_motion gravity lift wind stiffness collision elasticity"
    assert [use.name for use in scene_of(f"rules: {{{names}}}").rules] == order.split()


def test_a_rule_that_lacks_a_part_or_whose_name_is_taken_is_refused(lift: object) -> None:
    class Nameless:
        order = 1.0

    with pytest.raises(UsageError, match="has no `name`"):
        register(Nameless())

    class Second:
        name, order, Parameters = "gravity", 1.0, object

        def passes(self, parameters: object, scene: object) -> list[Pass]:
            return []

    with pytest.raises(UsageError, match="rule 'gravity': another rule has this name"):
        register(Second())
    register(lift)  # the same again is no fault
    assert registry()["lift"] is lift


@pytest.fixture
def installed(tmp_path: Path) -> Path:
    """A folder that holds an installed package with the rule."""
    (tmp_path / "lift_rule.py").write_text(RULE, encoding="utf-8")
    info = tmp_path / "lift-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: lift\nVersion: 1.0\n", encoding="utf-8")
    (info / "entry_points.txt").write_text("[strandcli.rules]\nlift = lift_rule\n", encoding="utf-8")
    return tmp_path


def run(code: str, folder: Path) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(folder), str(Path(__file__).parents[1])])
    return subprocess.run(
        [sys.executable, "-c", dedent(code)], capture_output=True, text=True, env={**os.environ, "PYTHONPATH": path}
    )


def test_a_rule_is_found_by_its_entry_point(installed: Path) -> None:
    done = run(
        f"""
        from strand_kit import frames_of, scene_of
        frames = frames_of(scene_of({SCENE % "lift: {strength: 24}"!r}), 1, 4, draw=False)
        print(round(float((frames[1].positions - frames[0].positions)[:, 1:, 1].min()), 6))
        """,
        installed,
    )
    assert done.stderr == ""
    assert done.stdout == "0.125\n"


def test_a_rule_that_cannot_be_imported_is_named(installed: Path) -> None:
    (installed / "lift_rule.py").write_text("import a_module_that_is_not_there\n", encoding="utf-8")
    done = run("from strandcli.cli.main import main\nraise SystemExit(main(['plan', 'x.yaml']))", installed)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert "rule 'lift' (lift_rule) cannot be imported: No module named 'a_module_that_is_not_there'" in done.stderr
