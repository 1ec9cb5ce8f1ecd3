"""Extreme and awkward scenes, all the way to a picture: numbers stay numbers and nothing ends in a crash."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from strand_kit import frames_of
from strandcli.draw.film.kernels import film
from strandcli.scene import Scene, loads
from strandcli.simulate.rules import registry

EVERYTHING = """
emitter:
  strands: 80
  particles: 5
  length: 0.8
  jitter: 20
  shape: {kind: sphere, radius: 0.5}
  keys: [{time: 0}, {time: 1, position: [0.2, 0.1, 0], rotation: [10, 300, 20]}]
time: {fps: 10, frames: 3}
solids:
- {kind: sphere, name: ball, radius: 0.5}
- {kind: capsule, name: arm, radius: 0.3, position: [0, 1, 0], rotation: [20, 0, 40]}
- {kind: plane, name: ground, position: [0, -0.7, 0]}
- {kind: box, name: crate, position: [1, 0, 0], rotation: [10, 20, 30], size: [0.9, 0.8, 0.7]}
rules:
- emitter_motion
- gravity
- wind: {gust: 1, wavelength: 2}
- stiffness
- collision: {segments: true}
- elasticity
camera: {position: [0, 0.5, 4], near: 0.01}
image: {size: [40, 32]}
lights: [{kind: directional, shadow: {size: 64}}, {kind: point, shadow: {size: 64}}]
material: {colour_variation: 0.3, tip_colour: [0.5, 0.4, 0.2]}
"""
UNLIT = "rules: [elasticity]\nemitter: {strands: 20, particles: 3}\nimage: {size: [20, 16]}\nmaterial: {specular: 0}\n"

CHANGES: dict[str, dict[str, Any]] = {
    "as it is": {},
    "one strand of two particles": {"emitter.strands": 1, "emitter.particles": 2},
    "one strand along the light": {
        "emitter.strands": 1,
        "emitter.direction": [-0.5, -1, -0.5],
        "emitter.jitter": 0,
        "rules": [],
    },
    "lengths down to nothing": {"emitter.length_variation": 1, "emitter.strands": 500},
    "a cap without area": {"emitter.shape.cap": 1e-9},
    "roots in one place": {"emitter.shape": {"kind": "plane", "width": 1e-9, "depth": 1e-9}},
    "far from the origin": {
        "emitter.keys": [{"time": 0, "position": [1e6, 2e6, -1e6]}, {"time": 1, "position": [1e6, 2e6, -1e6 + 1]}],
        "camera": {"position": [1e6, 2e6, -1e6 + 4], "target": [1e6, 2e6, -1e6]},
    },
    "camera inside the hair": {"camera.position": [0, 0, 0.8]},
    "camera that sees nothing": {"camera.target": [0, 0.5, 8]},
    "near plane behind everything": {"camera.near": 1e9},
    "hardly any field of view": {"camera.fov": 1e-9},
    "orthographic inside the hair": {"camera.kind": "orthographic", "camera.position": [0, 0, 0.3]},
    "orthographic of no height": {"camera.kind": "orthographic", "camera.height": 1e-9},
    "one pixel": {"image.size": [1, 1]},
    "no light from the lights": {"lights.0.intensity": 0, "lights.1.colour": [0, 0, 0]},
    "light at a root": {"lights.1.position": [0, 0.5, 0]},
    "light very far away": {"lights.1.position": [1e8, 1e9, 1e7], "lights.1.intensity": 1e9},
    "glaring light": {"lights.0.intensity": 1e9, "image.exposure": 20},
    "maps of one texel": {"lights.0.shadow.size": 1, "lights.1.shadow.size": 1},
    "a bias beyond everything": {"lights.0.shadow.bias": 1e9},
    "hair of no width": {"material.width": 1e-9},
    "hair as wide as the world": {"material.width": 1e9, "image.size": [8, 6]},
    "black": {"material.colour": [0, 0, 0], "material.tip_colour": [0, 0, 0], "ambient": [0, 0, 0]},
    "whiter than white": {"material.colour": [1e9, 1, 0], "ambient": [1e9, 1, 0]},
    "sharpest highlights": {"material.beta": 0.1, "material.azimuthal": 1, "material.specular": 10},
    "finest curves": {"curves.level": 8, "curves.tolerance": 1e-9, "emitter.strands": 5},
    "tiny solids": {
        "solids.0.radius": 1e-9,
        "solids.1.radius": 1e-9,
        "solids.1.length": 0,
        "solids.3.size": [1e-9] * 3,
    },
    "huge solids": {"solids.0.radius": 1e9, "solids.1.radius": 1e9, "solids.3.size": [1e9] * 3},
    "a storm": {"wind.strength": 1e6, "gravity.acceleration": [0, -1e6, 0]},
    "level of detail": {"detail": {"near": 1e-9, "fraction": 1e-9}},
}
for _scale in (1e-5, 1e-3, 1e3, 1e6):
    CHANGES[f"scale {_scale:g}"] = {
        "emitter.length": 0.8 * _scale, "emitter.shape.radius": 0.5 * _scale,
        "emitter.keys": [{"time": 0}, {"time": 1, "position": [_scale, 0, 0], "rotation": [0, 90, 0]}],
        "solids.0.radius": 0.5 * _scale, "solids.1.radius": 0.3 * _scale, "solids.1.position": [0, _scale, 0],
        "solids.1.length": _scale,
        "solids.2.position": [0, -0.7 * _scale, 0], "solids.3.size": [_scale] * 3, "solids.3.position": [_scale, 0, 0],
        "camera.position": [0, 0.5 * _scale, 4 * _scale], "camera.near": 0.01 * _scale,
        "lights.1.position": [3 * _scale] * 3, "lights.1.intensity": min(30 * _scale**2, 1e9),
        "wind.wavelength": 2 * _scale, "wind.strength": 10, "gravity.acceleration": [0, -9.81 * _scale, 0],
    }  # fmt: skip


def scene_of(text: str, changes: dict[str, Any]) -> Scene:
    """A scene with some settings changed, as a panel has them."""
    (panel,) = loads(f"{text}panels: [{{set: {json.dumps(changes)}}}]", rules=registry(), name="test.yaml").panels
    return panel


@pytest.fixture
def linear(monkeypatch: pytest.MonkeyPatch) -> list[np.ndarray]:
    """Every picture before it is encoded."""
    seen: list[np.ndarray] = []
    develop = film.develop

    def watched(image: np.ndarray, *rest: Any) -> None:
        seen.append(image.copy())
        develop(image, *rest)

    monkeypatch.setattr(film, "develop", watched)
    return seen


@pytest.mark.parametrize("changes", CHANGES.values(), ids=CHANGES.keys())
def test_a_picture_comes_of_it(changes: dict[str, Any], linear: list[np.ndarray]) -> None:
    scene = scene_of(EVERYTHING, changes)
    frames = frames_of(scene, 1, 3, threads=1)  # pictures so small are not worth a second thread
    width, height = scene.image.size
    for frame, light in zip(frames, linear, strict=True):
        assert frame.positions is not None
        assert frame.image.shape == (height, width, 3)
        assert frame.image.dtype == np.uint8
        assert np.isfinite(frame.positions).all()
        assert np.isfinite(light).all()
        assert (light >= 0).all()
        for number in frame.report["error"].values():
            assert number is None or np.isfinite(number)
        assert frame.report["counts"]["fragments"] <= width * height * scene.image.supersample**2


FINE: dict[str, Any] = {
    "solver": "rod",
    "rules": ["emitter_motion", "gravity", "wind", {"collision": {"segments": True}}],
    "image.resolver": "sorted",
    "image.aovs": ["depth", "mask", "tangent", "orientation", "strand_id", "shadow", "linear"],
    "lights.0.shadow.model": "opacity",
    "lights.1.shadow.model": "opacity",
    "material.model": "chiang",
    "material.pigment": "blond",
    "material.grey": 0.2,
    "material.scatter": "dual",
    "material.width": 0.004,
    "children": {
        "count": 4, "cut": 0.4, "undercoat": 0.2,
        "clumps": [{"size": 0.2, "strength": 0.7}], "waves": [{"radius": 0.02, "length": 0.2, "round": 1}],
    },
}  # fmt: skip
"""Everything that the source has not."""
FINE_CHANGES: dict[str, dict[str, Any]] = {
    "smooth as glass": {"material.beta_m": 0.001, "material.beta_n": 0.001},
    "without pigment": {"material.pigment": "white"},
    "blacker than black": {"material.eumelanin": 50, "material.pheomelanin": 50},
    "without any opacity": {"material.opacity": 0},
    "maps of one layer and of many": {"lights.0.shadow.layers": 1, "lights.1.shadow.layers": 61},
    "texels of no size": {"lights.0.shadow.texel": 1e-9, "lights.1.shadow.texel": 1e9},
    "hardly a strand left": {"detail": {"pixels": 100}},
    "an open lens and shutter": {"camera.aperture": 0.1, "camera.shutter": 0.5, "camera.samples": 3},
    "locks of a strand each": {"children.clumps": [{"size": 1e-6, "strength": 1}]},
    "waves beyond all bounds": {"children.waves": [{"radius": 1e6, "length": 1e-6, "round": 1}]},
    "strands cut to nothing": {"children.cut": 0.999, "children.undercoat": 1, "children.undercoat_length": 0.001},
}


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize("changes", FINE_CHANGES.values(), ids=FINE_CHANGES.keys())
def test_a_picture_of_the_finer_look_comes_of_it(changes: dict[str, Any], linear: list[np.ndarray]) -> None:
    (frame,) = frames_of(scene_of(EVERYTHING, FINE | changes), 3, threads=1)
    assert frame.image is not None
    assert np.isfinite(linear[0]).all()
    assert (linear[0] >= 0).all()
    for name, layer in frame.aovs.items():
        if name == "depth":  # infinite where there is nothing
            assert (layer > 0).all()
        elif layer.dtype.kind == "f":
            assert np.isfinite(layer).all()


@pytest.mark.parametrize("scale", [1e-5, 1e6])
def test_the_same_scene_at_another_scale_is_the_same_picture(scale: float) -> None:
    """But for what rounding moves over the border of a pixel. Nothing moves here."""
    still = {"rules": [], "lights.1.intensity": 0}  # a point's light falls with the square of the scale
    usual = frames_of(scene_of(EVERYTHING, CHANGES["scale 1000"] | still), 1, threads=1)[0].image
    other = frames_of(scene_of(EVERYTHING, CHANGES[f"scale {scale:g}"] | still), 1, threads=1)[0].image
    assert other is not None
    assert len(np.unique(usual)) > 50
    assert np.abs(usual.astype(int) - other).mean() < 1.0
