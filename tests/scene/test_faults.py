"""All faults at once, each with its place and path, and the checks of a scene as a whole."""

from __future__ import annotations

import pickle

import pytest

from scene_kit import complaint, complaints, faults, scene
from strandcli.scene import Fault, SceneError

BAD = """\
title: hair
tme: 3
time: {fps: 0, frames: 10.5}
emitter:
  strenght: 3
  length: .nan
  shape: {kind: disk, radius: -1}
wind: {strength: 2}
rules:
  - gravity
  - wind: {strenght: 3, direction: [0, 0, 0]}
  - wnd
  - collision: {with: [hed]}
solids:
  - radius: 3
  - {kind: sphere, name: head}
  - {kind: box, name: head}
camera: {fov: 200, position: [0, 0, 0]}
title: again
"""


def test_all_faults_are_told_at_once_in_file_order() -> None:
    assert [(fault.line, fault.column, fault.path) for fault in faults(BAD)] == [
        (2, 1, "tme"),
        (3, 13, "time.fps"),
        (3, 24, "time.frames"),
        (5, 3, "emitter.strenght"),
        (6, 11, "emitter.length"),
        (7, 17, "emitter.shape.kind"),
        (8, 1, "wind"),
        (11, 12, "wind.strenght"),
        (11, 36, "wind.direction"),
        (12, 5, "rules"),
        (15, 5, "solids.0"),
        (17, 23, "solids.2.name"),
        (18, 15, "camera.fov"),
        (18, 30, "camera.position"),
        (19, 1, ""),
    ]


def test_a_scene_error_is_a_line_a_fault_and_survives_pickling() -> None:
    error = SceneError([Fault("a.yaml", 1, 2, "b", "is bad"), Fault("--set c=3", 0, 0, "c", "is worse")])
    assert str(error) == "a.yaml:1:2: b: is bad\n--set c=3: is worse"
    assert error.exit_code == 2
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.faults) == (str(error), error.faults)


def test_unknown_keys_are_put_right_or_told_what_there_is() -> None:
    assert complaint("strands: 5").endswith("strands: unknown key; did you mean 'emitter.strands'?")
    assert complaint("camera: {positon: [0, 0, 1]}").endswith("unknown key; did you mean 'position'?")
    assert complaint("camera: {FOV: 3}").endswith("did you mean 'fov'?")
    assert complaint("time: {zzz: 3}").endswith(
        "unknown key; the keys are frames, fps, substeps, jitter, preroll, loop"
    )
    assert complaint("rules: [elasticity: {a: 3}]").endswith("unknown key; there are no settings here")
    assert "belongs under `rules`" in complaint("gravity: {}")


def test_what_a_fault_makes_uncertain_is_not_complained_about_as_well() -> None:
    # the default position (0, 0, 5) stands in for the faulty one
    assert complaint("camera: {position: [a, 0, 0], target: [0, 0, 5]}").startswith("p.yaml:1:21: camera.position.0")
    # the second solid may have had the name
    assert len(complaints("solids: [{kind: sfere, name: head}]\nrules: [collision: {with: head}]")) == 1


@pytest.mark.parametrize("thing", ["emitter: {keys: %s}", "camera: {keys: %s}", "solids: [{kind: sphere, keys: %s}]"])
def test_keys_go_forward_in_time(thing: str) -> None:
    assert scene(thing % "[{time: -1}, {time: 0}, {time: 0.5}]")
    for later in ("0", "-1", "0.0"):
        line = complaint(thing % f"[{{time: 0}}, {{time: {later}}}]")
        assert "keys.1.time: keys must go forward in time" in line
    assert "keys.1: keys must go forward" in complaint(thing % "[{time: 0}, {}]").replace(".time:", ":")


def test_particles_too_close_for_single_precision() -> None:
    line = complaint("emitter: {length: 0.001, particles: 10000}")
    assert "emitter.length: 10000 particles on 0.001 m stand 1e-07 m apart" in line
    assert scene("emitter: {length: 0.001, particles: 1000}")


@pytest.mark.parametrize(
    ("camera", "place", "says"),
    [
        ("{position: [0, 0, 0]}", "camera.position", "stands at its own target"),
        ("{position: [0, 4, 0]}", "camera.position", "along `up`"),
        ("{up: [0, 0, -2]}", "camera.up", "along `up`"),
        ("{keys: [{time: 0}, {time: 1, position: [0, 0, 0]}]}", "camera.keys.1.position", "stands at its own target"),
        (
            "{keys: [{time: 0, position: [0, 0, 5]}, {time: 1, position: [0, 0, -5]}]}",
            "camera.keys.1.position",
            "passes through its own target",
        ),
        (
            "{keys: [{time: 0, position: [0, 5, 5]}, {time: 1, position: [0, 5, -5]}]}",
            "camera.keys.1.position",
            "looks along `up`",
        ),
    ],
)
def test_a_camera_looks_somewhere(camera: str, place: str, says: str) -> None:
    line = complaint(f"camera: {camera}")
    assert f": {place}: " in line
    assert says in line


def test_locks_are_listed_from_wide_to_narrow() -> None:
    line = complaint("children:\n  clumps:\n    - {size: 0.01}\n    - {size: 0.02}\n")
    assert line.startswith("p.yaml:4:")
    assert "children.clumps.1.size" in line
    assert "from wide to narrow" in line
    assert [clump.size for clump in scene("children: {clumps: [{size: 0.02}, {size: 0.01}]}").children.clumps] == [
        0.02, 0.01
    ]  # fmt: skip


@pytest.mark.parametrize("quality", ["", "quality: default\n"])
def test_too_many_lights_or_panels_are_refused_at_once(quality: str) -> None:
    assert complaint(f"{quality}lights:\n" + "- {kind: nope}\n" * 30_000).endswith(
        "lights: may have 256 entries at the most, not 30,000"
    )
    assert complaint(f"{quality}panels:\n" + "- {label: a}\n" * 20_000).endswith(
        "panels: may have 100 entries at the most, not 20,000"
    )
