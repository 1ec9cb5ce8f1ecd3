"""Axes of pictures: their own measures against what is known by hand, and the command on a small groom."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import strandcli
from cli_runs import Runner
from strandcli.draw.view.camera import axes
from strandcli.study.kernels import cylinders
from strandcli.study.pictures.shadow import ShadingRenderer, ShadowStudy, frames_along, pieces_of
from strandcli.study.pictures.subject import Subject
from strandcli.study.sweep import Request, changed, knows

SMALL = """\
title: a small brush
emitter: {shape: {kind: sphere, radius: 0.3}, strands: 60, particles: 5, length: 0.8, jitter: 20, curl_turns: 0.5}
camera: {position: [0, 0.3, 4], fov: 34}
image: {size: [32, 24]}
lights: [{kind: directional, direction: [0.3, -1, -0.5], shadow: {size: 64}}]
rules: {elasticity: {}}
"""
AXES = ("coverage", "shadow", "quality")


@pytest.fixture
def run(run: Runner) -> Runner:
    Path("brush.yaml").write_text(SMALL)
    return run


def test_what_is_studied_is_what_is_drawn_children_included(tmp_path: Path) -> None:
    children = "children: {count: 4, cut: 0.5, clumps: [{size: 0.1, strength: 0.8}], waves: [{radius: 0.02}]}"
    material = "material: {width: 0.01, colour_variation: 0.5}"
    (tmp_path / "locks.yaml").write_text(f"{SMALL}{children}\n{material}\n")
    scene = strandcli.load(str(tmp_path / "locks.yaml"), overrides=["image.aovs=linear"])
    subject = Subject(Request(scene=scene, name="locks", frame=2))
    subject.move()
    found = subject.draw(subject.scene, draws=1)
    frame = next(iter(strandcli.render(scene, frames=[2])))
    assert found.counts["strands"] == frame.report["counts"]["strands"] == 240
    np.testing.assert_allclose(found.image, frame.aovs["linear"], rtol=1e-5, atol=1e-7)


def test_the_first_of_the_children_are_studied_where_fewer_are_asked_for(run: Runner, tmp_path: Path) -> None:
    (tmp_path / "locks.yaml").write_text(f"{SMALL}children: {{count: 4}}\n")
    found = json.loads(run("study", "locks.yaml", "--axis", "shadow", "--strands", "70", "--json").out)
    assert found["reference"]["strands"] == 70
    assert "70 of 240 strands" in found["title"]


def test_frames_of_many_ways_are_those_of_each() -> None:
    ways = np.array([[1.0, 2, 3], [-4, 0.5, 0], [0, 0, -2], [0.3, -0.3, 0.1], [0, 5, 0], [0, -1, 0]])
    np.testing.assert_allclose(frames_along(ways), [axes(way, (0.0, 1.0, 0.0)) for way in ways], atol=1e-15)


def test_rays_are_stopped_by_what_stands_in_their_way() -> None:
    """A strand along x, one deep behind and one beyond the light; rays over a line across of it."""
    world = np.array([[-1.0, 0, 1], [1, 0, 1], [-1, 0.3, -1], [1, 0.3, -1], [-1, -0.3, 9], [1, -0.3, 9]])
    first = np.array([0, 2, 4, 6])
    radii = np.full(6, 0.1)
    probes = np.zeros((2, 3))
    jitter = np.stack([np.zeros(400), np.linspace(-0.5, 0.5, 400)], 1)
    frames = np.broadcast_to(np.eye(3), (2, 3, 3)).copy()
    out = np.empty((2, 2))
    wide = np.array([1.0, 0.5])
    pieces = pieces_of(first, world, radii)
    cylinders.transmittance(pieces, probes, np.array([-1, 0]), frames, np.full(2, 5.0), jitter, wide, out)
    assert out[0] == pytest.approx(1 - 0.2, abs=0.01)
    assert (out[1] == 1).all()  # the strand that a probe is on does not count


@pytest.mark.long
def test_shadow_is_measured_apart_from_how_strands_scatter(tmp_path: Path) -> None:
    """Maps alone are judged: not light from strand to strand, nor an environment's."""
    (tmp_path / "brush.yaml").write_text(SMALL)
    (tmp_path / "sky.hdr").write_bytes(
        b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n" + bytes([128, 128, 128, 129] * 2)
    )
    found = []
    for more in ([], ["material.scatter=dual", "material.diffuse=0", f"environment.image={tmp_path / 'sky.hdr'}"]):
        scene = strandcli.load(str(tmp_path / "brush.yaml"), overrides=["material.model=chiang", *more])
        study = ShadowStudy(Request(scene=scene, name="brush"))
        study.prepare(lambda text: None)
        parameters = {"lights.0.shadow.model": "opacity", "lights.0.shadow.size": 64}
        found.append((study.truth.mean(), study.errors(parameters, study.subject.draw(study.scene, draws=1))))
    assert found[0] == found[1]
    assert found[0][1]["transmittance"] < 0.1


def test_light_at_vertices_is_the_same_however_many_bands_of_rows_a_picture_has(tmp_path: Path) -> None:
    (tmp_path / "brush.yaml").write_text(SMALL)
    subject = Subject(Request(strandcli.load(str(tmp_path / "brush.yaml"), ["image.resolver=sorted"]), "brush"))
    subject.move()
    whole, bands = (ShadingRenderer(subject.scene, subject.groom) for _ in range(2))
    bands.coverage.room = subject.draw(subject.scene, 1, whole).counts["fragments"] // 3
    assert subject.draw(subject.scene, 1, bands).counts["fragments"] > 2 * bands.coverage.room
    for one, other in zip(whole.vertices(0.0), bands.vertices(0.0), strict=True):
        assert len(one)
        np.testing.assert_array_equal(one, other)


def test_settings_by_path() -> None:
    scene = strandcli.load("hair")
    assert knows(scene, "lights.0.shadow.model", "minmax")
    assert not knows(scene, "lights.0.shadow.model", "painted")
    assert not knows(scene, "lights.7.shadow.model")
    assert knows(scene, "detail.near")
    other = changed(scene, {"lights.0.shadow.size": 32, "detail.fraction": 0.5})
    assert (other.lights[0].shadow.size, scene.lights[0].shadow.size) == (32, None)
    assert other.detail.fraction == 0.5


@pytest.mark.parametrize("axis", AXES)
def test_every_axis_of_a_small_groom(run: Runner, axis: str) -> None:
    data = json.loads(run.fine("study", "brush.yaml", "--axis", axis, "--json", "-q", "-o", "s").out)
    assert data["axis"] == axis
    errors = [point["error"][data["metric"]] for point in data["points"]]
    assert all(error is not None and error >= 0 for error in errors)
    assert any(point["pareto"] for point in data["points"])
    assert all(point["seconds"] > 0 for point in data["points"])
    by_name = {json.dumps(point["parameters"], sort_keys=True): error
               for point, error in zip(data["points"], errors, strict=True)}  # fmt: skip
    if axis == "coverage":
        fine = [error for name, error in by_name.items() if '"image.supersample": 8' in name]
        coarse = [error for name, error in by_name.items() if '"image.supersample": 1' in name]
        assert min(fine) < 0.5 * max(coarse)
        assert max(error for name, error in by_name.items() if "sorted" in name and ": 4" in name) < min(coarse)
    if axis == "shadow":
        assert data["reference"]["noise"] < 0.02
        assert by_name['{"lights.0.shadow.model": "off"}'] == pytest.approx(1 - data["reference"]["mean"])
    rows = list(csv.DictReader(Path(f"s/brush-{axis}.csv").read_text().splitlines()))
    assert len(rows) == len(data["points"])


def test_what_is_set_by_hand_is_not_turned_and_what_does_not_fit_is_refused(run: Runner) -> None:
    done = run.fine("study", "brush.yaml", "--axis", "coverage", "--set", "image.supersample=3", "--json", "-q")
    assert {point["parameters"]["image.supersample"] for point in json.loads(done.out)["points"]} == {3}
    for options, word in (
        (("--axis", "coverage", "--dt", "1/24"), "--dt"),
        (("--axis", "coverage", "--frame", "900"), "--frame 900"),
        (("--axis", "coverage", "--strands", "9"), "--strands: axis coverage draws all of them"),
        (("--frame", "2"), "--frame"),
        (("--axis", "shadow", "--set", "lights=[]"), "no light"),
        (("--axis", "colour"), "no axis 'colour'"),
    ):
        assert word in run.refused("study", "brush.yaml", *options, "-o", "other")


def test_what_memory_cannot_hold_is_refused_before_anything_runs(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("strandcli.plan.make.available_memory", lambda: 10**8)
    for words in (("study", "brush.yaml", "--axis", "coverage"), ("bench", "--strands", "100000000")):
        assert "100 MB that are free" in run.refused(*words, code=4)


def test_an_error_that_nothing_keeps_under(run: Runner) -> None:
    done = run.refused("study", "brush.yaml", "--axis", "coverage", "--max-error", "0.0001%", "-q", "-o", "s", code=3)
    assert "allow a greater error" in done
