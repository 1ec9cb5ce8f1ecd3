"""Solids' shadows in lights that have a size, against rays to points of the light; and models from outside."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from shadow_kit import soft_visibility
from strand_kit import frames_of, scene_of
from strandcli import load
from strandcli.cli.main import main
from strandcli.common.registry import SHADOWS
from strandcli.draw.shadows.kernels import penumbra
from strandcli.draw.shadows.shadow_model import ShadowModel
from strandcli.draw.shadows.vertex_shadows import StrandsInLight, VertexShadows
from strandcli.draw.solids.kernels import rays as cast
from strandcli.errors import UsageError
from strandcli.plan import make_plan
from strandcli.scene import SceneError
from strandcli.solids import Solids, pack_all

SKIN = np.float32(1e-6)
FAR = np.float32(1e30)
SCENES = {
    "ball": "{kind: sphere, radius: 0.5, position: [0.1, 0, 0.2]}",
    "small ball": "{kind: sphere, radius: 0.12, position: [0, 0, 0.2]}",
    "capsule": "{kind: capsule, radius: 0.3, length: 1.4, rotation: [20, 0, 50]}",
    "capsule seen from its end": "{kind: capsule, radius: 0.3, length: 1.4}",
    "box": "{kind: box, size: [0.8, 0.6, 1.1], rotation: [25, 40, 10]}",
    "plane": "{kind: plane, position: [0, -1.5, 0], rotation: [0, 0, 35]}",
}


def packed_of(solid: str) -> Solids:
    scene = scene_of(f"emitter: {{strands: 1}}\nrules: []\nsolids: [{solid}]\n")
    return pack_all(scene.solids, scene.emitter, 0.0)


def disc(count: int) -> NDArray[np.float64]:
    """(count, 2) points spread evenly over the unit disc (Vogel 1979)."""
    k = np.arange(count) + 0.5
    angle = k * math.pi * (3 - math.sqrt(5))
    return np.stack([np.cos(angle), np.sin(angle)], 1) * np.sqrt(k / count)[:, None]


def ray_of(where: Any, way: Any, reach: Any = FAR) -> penumbra.LightRay:
    """The ray from a point along a unit vector, in single precision."""
    return penumbra.LightRay(*where.astype(np.float32), *way.astype(np.float32), reach)


def by_rays(packed: Any, where: Any, middle: Any, radius: float, rays: int = 600) -> float:
    """Share of a disc of directions about a unit vector, ``radius`` the sine of its angular radius, that are free."""
    side = np.cross(middle, [0.31, -0.52, 0.79])
    side /= np.linalg.norm(side)
    up = np.cross(middle, side)
    free = 0.0
    for u, v in disc(rays) * radius:
        way = (math.sqrt(1 - u * u - v * v) * middle + u * side + v * up).astype(np.float32)
        free += float(cast.visibility(packed, *where.astype(np.float32), *way, FAR, SKIN))
    return free / rays


@pytest.mark.parametrize("name", [name for name in SCENES if name != "plane"])
def test_a_round_light_is_hidden_as_much_as_rays_find(name: str) -> None:
    """Over a line of points through the penumbra of a light five degrees wide, ten times the sun. What is left are
    edges that bend within the light's width: a small ball's, a capsule's end, a box's corner."""
    packed = packed_of(SCENES[name])
    middle = np.array([0.1, 1.0, 0.15])
    middle /= np.linalg.norm(middle)
    radius = math.sin(math.radians(2.5))
    found, right = [], []
    for x in np.linspace(-1.6, 1.6, 65):
        where = np.array([x, -1.2, 0.05])
        one = soft_visibility(packed, ray_of(where, middle), SKIN, np.float32(radius), np.float32(0))
        found.append(float(one))
        right.append(by_rays(packed, where, middle, radius))
    assert min(right) < 0.5
    assert max(right) > 0.95
    off = np.subtract(found, right)
    print(f"\n{name}: {np.abs(off).max():.3f} at the most, {off.mean():+.4f} on average")
    assert np.abs(off).max() < 0.07
    assert abs(off.mean()) < 0.005


@pytest.mark.parametrize("name", SCENES)
def test_a_light_of_almost_no_size_is_a_point(name: str) -> None:
    packed = packed_of(SCENES[name])
    generator = np.random.default_rng(3)
    differ = 0
    for _ in range(400):
        where, middle = generator.normal(size=(2, 3))
        where *= generator.uniform(1.05, 1.6) / np.linalg.norm(where)
        middle -= where  # often enough toward the solid
        middle /= np.linalg.norm(middle)
        numbers = (*where.astype(np.float32), *middle.astype(np.float32), FAR, SKIN)
        tiny = soft_visibility(packed, ray_of(where, middle), SKIN, np.float32(1e-4), np.float32(0))
        differ += abs(tiny - cast.visibility(packed, *numbers)) > 0.01
    assert differ <= 2


def test_a_lamp_is_as_wide_as_it_is_near() -> None:
    """The edge of a plane half way to a ball of light, whose middle is a quarter of its radius above the edge's
    shadow: the closed form of the disc's part."""
    packed = packed_of("{kind: plane, position: [0, 0, 0]}")
    height, radius = 0.05, 0.2
    lamp = np.array([3.0, height, 0.0])
    where = np.array([0.0, 0.0, 0.0])
    reach = np.linalg.norm(lamp - where)
    way = (lamp - where) / reach
    found = soft_visibility(packed, ray_of(where, way, np.float32(reach)), SKIN, np.float32(radius), np.float32(1))
    x = height / radius
    assert found == pytest.approx(1 - (math.acos(x) - x * math.sqrt(1 - x * x)) / math.pi, abs=1e-4)


def test_a_picture_has_soft_shadows_of_the_same_light(tmp_path: Path) -> None:
    """A ball's shadow on the ground: wider lights soften its edge, and in the dark it stays as it was."""
    text = """\
emitter: {shape: {kind: disc, radius: 0.01}, strands: 4, particles: 3, length: 0.01}
rules: []
camera: {position: [0, 6, 0.01], target: [0, 0, 0], fov: 40}
image: {size: 96x96, supersample: 1}
ambient: [0, 0, 0]
solids: [{kind: sphere, radius: 0.4, position: [-0.2, 0.9, 0]}, {kind: plane, colour: [0.3, 0.3, 0.3]}]
lights: [{kind: directional, direction: [-1, -1, 0], size: %s}]
"""
    pictures = []
    for size in (0, 8, 16):
        path = tmp_path / f"{size}.yaml"
        path.write_text(text % size)
        image = frames_of(load(str(path)), 1)[0].image
        pictures.append(image[:, :30].astype(np.float64).mean(2))
    steps = [np.abs(np.diff(picture[40:56], axis=1)).max() for picture in pictures]
    assert steps[0] > 2 * steps[1] > 2.5 * steps[2]
    assert pictures[0][48, 24] == pictures[1][48, 24] == pictures[2][48, 24]


EXAMPLE = Path(__file__).parents[3] / "examples/shadow_model.py"
SCENE = """
image: {size: [32, 64], background: [0, 0, 0], aovs: [linear], resolver: %s}
emitter: {shape: {kind: disc, radius: 0.000001}, strands: 1, particles: 60, length: 4.0}
camera: {kind: orthographic, position: [0, 2, 5], target: [0, 2, 0], height: 4.4}
curves: {mode: "off"}
rules: []
ambient: [0, 0, 0]
lights: [{kind: directional, direction: [0, 0, -1], intensity: 200.0, shadow: {model: %s}}]
material: {width: %g, taper: 0, diffuse: 1, specular: 0}
"""


class Dimmer(ShadowModel):
    """Strands leave a quarter of the light everywhere."""

    name = "dimmer"
    shades_vertices = True

    def vertex_shadows(self, light: Any, strands: StrandsInLight) -> VertexShadows:
        class Quarter(VertexShadows):
            def visibility(self, lines: Any, marks: Any, screen: Any, out: Any) -> None:
                out[marks != 0] = 0.25

        assert strands.number == 0
        return Quarter()


@pytest.fixture
def models(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """Both models, registered for one test."""
    monkeypatch.syspath_prepend(str(EXAMPLE.parent))
    import shadow_model

    dimmer = Dimmer()
    for model in (dimmer, shadow_model.MODEL):
        SHADOWS.register(model)
    yield shadow_model
    for name in ("dimmer", "mist"):
        del SHADOWS._drivers[name]


def column(resolver: str, model: str, width: float = 0.1) -> np.ndarray:
    """Linear light down the picture's middle."""
    frame = frames_of(scene_of(SCENE % (resolver, model, width)), 1)[0]
    return np.asarray(frame.aovs["linear"], np.float64)[:, :, 1].sum(1)


@pytest.mark.parametrize("width", [0.01, 0.5])
@pytest.mark.parametrize("resolver", ["zbuffer", "sorted"])
def test_a_dimmer_leaves_a_quarter_of_the_light(models: Any, resolver: str, width: float) -> None:
    """Of thin strands, and of strands so wide that light differs across them."""
    dim, off = (column(resolver, model, width)[4:60].mean() for model in ("dimmer", "'off'"))
    assert off > 0.001
    assert dim == pytest.approx(0.25 * off, rel=0.01)


@pytest.mark.parametrize("resolver", ["zbuffer", "sorted"])
def test_mist_leaves_its_closed_form(models: Any, resolver: str) -> None:
    """A ball of radius .8 about (0, 2, 1): at height y light goes 2 √(.64 − (y − 2)²) through it."""
    mist, off = (
        column(resolver, model, 0.03)
        for model in ("mist, parameters: {centre: [0, 2, 1], radius: 0.8, density: 1.5}", "'off'")
    )
    rows = np.arange(3, 61)
    height = 2 + 2.2 - (rows + 0.5) * 4.4 / 64
    way = 2 * np.sqrt(np.maximum(0.64 - (height - 2) ** 2, 0))
    left = mist[rows] / off[rows]
    edge = np.abs(np.abs(height - 2) - 0.8) < 0.12  # where the light between two vertices is no straight line
    np.testing.assert_allclose(left[~edge], np.exp(-1.5 * way)[~edge], atol=0.02)
    assert left.min() < 0.12


def test_a_lamp_inside_of_the_mist(models: Any) -> None:
    """A vertex a metre from a lamp in the middle of a ball of radius .5 has e^-(.5 density) of it; one beside it, all
    but what lies between."""
    own = SimpleNamespace(centre=(0.0, 0.0, 0.0), radius=0.5, density=2.0)
    light = SimpleNamespace(kind="point", position=(0.0, 0.0, 0.0), shadow=SimpleNamespace(parameters=own))
    lines = SimpleNamespace(world=np.array([[1, 0, 0], [0, 0.25, 0], [0, 0, 3]], np.float32))
    out = np.full(3, -1.0, np.float32)
    models.MistShadows(light).visibility(lines, np.array([1, 1, 0], np.uint8), None, out)
    assert out == pytest.approx([math.exp(-1.0), math.exp(-0.5), -1.0], abs=1e-6)


def test_schema_plan_and_faults_know_of_a_new_model(models: Any, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema"]) == 0
    assert '"dimmer"' in capsys.readouterr().out
    scene = scene_of(SCENE % ("sorted", "mist", 0.1))
    assert scene.lights[0].shadow.parameters == models.Parameters()
    assert "shadow maps" in [stage.stage for stage in make_plan(scene, [1]).left_out]
    with pytest.raises(SceneError, match=r"radius"):
        scene_of(SCENE % ("sorted", "mist, parameters: {radius: 0}", 0.1))


def test_a_model_that_lacks_a_part_or_takes_a_name_is_refused(models: Any) -> None:
    with pytest.raises(UsageError, match="has no `casts_map`"):
        SHADOWS.register(SimpleNamespace(name="x"))
    taken = Dimmer()
    taken.name = "opacity"
    with pytest.raises(UsageError, match="another shadow model has this name"):
        SHADOWS.register(taken)
    with pytest.raises(SceneError, match="did you mean"):
        scene_of(SCENE % ("sorted", "dimer", 0.1))
    with pytest.raises(SceneError, match=r"'traced' is gone after .*; exact shadows are no part of this version"):
        scene_of(SCENE % ("sorted", "traced", 0.1))
