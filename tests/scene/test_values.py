"""Every kind of setting: what it takes, what it gives, and what it refuses."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scene_kit import complaint, scene
from strandcli.scene.fields import settings_of
from strandcli.scene.model import (
    Camera,
    CapsuleSolid,
    Detail,
    DirectionalLight,
    DiscShape,
    Emitter,
    PointLight,
    Scene,
)
from strandcli.scene.specs import LARGEST, Range


@pytest.mark.parametrize("empty", ["null", "~", "Null"])
def test_null_stands_for_the_default(empty: str) -> None:
    keys = [key for key in settings_of(Scene) if key != "panels"]
    assert scene("".join(f"{key}: {empty}\n" for key in keys)) == Scene()
    assert scene(f"camera: {{fov: {empty}}}").camera == Camera()


def test_an_empty_mapping_is_its_defaults_and_an_empty_value_a_fault() -> None:
    assert scene("emitter:\ncamera:\nrules:\ndetail:\n") == Scene(detail=Detail())
    assert complaint("seed:\n") == (
        "p.yaml:1:6: seed: must be a whole number of at least 0 and of at most 9223372036854775807, not nothing"
    )
    assert "solids: must be a list" in complaint("solids:\n")
    assert "must be three numbers" in complaint("camera: {up: }")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("emitter: {strands: 0}", "strands: must be a whole number of at least 1 and of at most 100000000, not '0'"),
        ("emitter: {particles: 1}", "emitter.particles: must be a whole number of at least 2"),
        ("emitter: {length: 0}", "emitter.length: must be a number above 0 (m), not '0'"),
        ("emitter: {length: 1e10}", "not '1e10'; single precision ends before that"),
        ("emitter: {length_variation: 1.1}", "must be a number of at least 0 and of at most 1, not '1.1'"),
        ("time: {fps: -1}", "time.fps: must be a number of at least 0"),
        ("camera: {fov: 180}", "camera.fov: must be a number above 0 and below 180 (deg), not '180'"),
        ("material: {eta: 1}", "material.eta: must be a number above 1 and of at most 3, not '1'"),
        ("image: {size: [0, 5]}", 'must be a size [w, h] or "800x600" of at least 1 and at most 32768 (px), not \'0\''),
        ("image: {size: big}", "not 'big'"),
        ("camera: {up: [0, 0, 0]}", "camera.up: must have a direction, not be zero"),
        ("camera: {up: [0, 1]}", "must be three numbers [x, y, z], not '[0, 1]'"),
        ("camera: {up: [0, 1, .inf]}", "camera.up.2: must be a number, not '.inf'; it must be finite"),
        ("ambient: [1, -1, 0]", "ambient.1: must be a number of at least 0, not '-1'"),
        ("ambient: red", "ambient: must be three linear numbers"),
        ("ambient: '#ff00'", "not '#ff00'"),
        ("image: {background: nothing}", '[r, g, b] or "#rrggbb" in quotes, or none, not'),
        ("curves: {mode: fixd}", "must be one of adaptive, fixed, off, thinned, not 'fixd'; did you mean 'fixed'?"),
        ("title: [a]", "title: must be text, not '[a]'"),
        ("camera: 3", "camera: must be a mapping of settings, not '3'"),
        ("solids: {kind: box}", "solids: must be a list, each entry beginning with `- `, not a mapping"),
        ("solids: [{}]", "solids.0: has no kind; the kinds are sphere, capsule, plane, box"),
        ("solids: [{kind: boks}]", "solids.0.kind: unknown kind 'boks'; did you mean 'box'?"),
        ("solids: [{kind: box, size: [1, 0, 1]}]", "solids.0.size.1: must be a number above 0 (m), not '0'"),
        ("emitter: {shape: {kind: cube}}", "shape.kind: unknown kind 'cube'; the kinds are sphere, disc, plane"),
        ("emitter: {shape: {kind: disc, cap: 3}}", "emitter.shape.cap: unknown key; the keys are kind, radius"),
        ("solver: thesys", "not 'thesys'; did you mean 'thesis'?"),
    ],
)  # fmt: skip
def test_refused(text: str, says: str) -> None:
    assert says in complaint(text)


def test_taken() -> None:
    got = scene(
        """
        title: "no"
        seed: 9223372036854775807
        emitter: {strands: 10.0, particles: 1e1, direction: [0, 2, 0], shape: {kind: disc, radius: 2}}
        image: {size: 640 x 480, background: "#ff8000", horizon: [2, 0, 0.5]}
        solids: [{kind: capsule, name: arm, length: 0, visible: false}]
        lights: [{kind: point, shadow: {model: "off"}}, {kind: directional}]
        detail: {near: 3}
        """
    )
    assert (got.title, got.seed) == ("no", 2**63 - 1)
    assert got.emitter == Emitter(strands=10, particles=10, direction=(0.0, 2.0, 0.0), shape=DiscShape(radius=2.0))
    assert (got.image.size, got.image.horizon) == ((640, 480), (2.0, 0.0, 0.5))
    assert got.solids == (CapsuleSolid(name="arm", length=0.0, visible=False),)
    assert [type(light) for light in got.lights] == [PointLight, DirectionalLight]
    assert got.lights[0].shadow.model == "off"
    assert got.detail == Detail(near=3.0)


def test_hex_colours_are_srgb() -> None:
    red, green, blue = scene('ambient: "#ff8000"').ambient
    assert (red, blue) == (1.0, 0.0)
    # IEC 61966-2-1 by its definition
    assert green == pytest.approx(((128 / 255 + 0.055) / 1.055) ** 2.4, abs=1e-15)


def test_types_are_exact_whatever_was_written() -> None:
    got = scene("time: {fps: 24, frames: 3.0}\ncamera: {position: [1, 2, 3]}\nimage: {size: [3.0, 4]}")
    assert type(got.time.fps) is float
    assert type(got.time.frames) is int
    assert [type(value) for value in got.camera.position] == [float] * 3
    assert [type(value) for value in got.image.size] == [int] * 2


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_ranges_hold_at_their_limits_and_nowhere_else(value: float) -> None:
    inside = abs(value) <= LARGEST
    assert Range(low=-1, high=1).holds(value) == (-1 <= value <= 1)
    assert Range(above=-1, below=1).holds(value) == (-1 < value < 1)
    assert Range().holds(value) == inside
    assert Range(low=2).holds(value) == (value >= 2 and inside)
    for limits in (Range(low=3, high=3), Range(low=3, below=math.inf), Range(above=2, high=3)):
        assert limits.holds(3)
