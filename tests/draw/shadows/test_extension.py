"""Shadow models from outside of the package: a constant dimmer, and the example's ball of mist in closed form."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from strand_kit import frames_of, scene_of
from strandcli.cli.main import main
from strandcli.common.registry import SHADOWS
from strandcli.draw.shadows.shadow_model import ShadowModel
from strandcli.draw.shadows.vertex_shadows import StrandsInLight, VertexShadows
from strandcli.errors import UsageError
from strandcli.plan import make_plan
from strandcli.scene import SceneError

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
