"""A fibre model from outside of the package: Kajiya and Kay's highlight, against its closed form."""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numba import typeof

import strandcli
from strand_kit import frames_of, scene_of
from strandcli.common.registry import FIBRES
from strandcli.errors import UsageError
from strandcli.jit import sources
from strandcli.plan import make_plan
from strandcli.scene import SceneError

EXAMPLE = Path(__file__).parents[3] / "examples/fibre_model.py"
SCENE = """
image: {size: [32, 32], background: [0, 0, 0], aovs: [linear]}
emitter: {shape: {kind: disc, radius: 0.000001}, strands: 1, particles: 8, length: 4.0}
camera: {kind: orthographic, position: [0, 2, 5], target: [0, 2, 0], height: 1.0}
curves: {mode: "off"}
ambient: [0, 0, 0]
lights: [{kind: directional, direction: [%s], intensity: 2.0, colour: [1, 0.5, 0.25], shadow: {model: "off"}}]
material: {model: kajiya_kay, width: 0.5, taper: 0, diffuse: 0, rounded: false%s}
"""


@pytest.fixture
def model(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """The example's module by its importable name, registered for one test."""
    monkeypatch.syspath_prepend(str(EXAMPLE.parent))
    import fibre_model

    FIBRES.register(fibre_model)
    yield fibre_model
    del FIBRES._drivers[fibre_model.name]


def light_at(theta: float) -> str:
    """The way of light from an inclination in degrees to a strand along +y, from the front."""
    angle = math.radians(theta)
    return f"0, {-math.sin(angle)}, {-math.cos(angle)}"


@pytest.mark.parametrize("resolver", ["zbuffer", "sorted"])
def test_a_pixel_shows_its_closed_form(model: Any, resolver: str) -> None:
    """The strand stands upright before the eye, θ_v = 0: radiance = E · strength · cos(θ_l)^exponent."""
    for theta, exponent, strength in ((0.0, 60.0, 0.6), (20.0, 60.0, 0.6), (-20.0, 8.0, 0.25), (70.0, 1.5, 0.4)):
        own = f", parameters: {{exponent: {exponent}, strength: {strength}}}"
        scene = scene_of(SCENE.replace("aovs:", f"resolver: {resolver}, aovs:") % (light_at(theta), own))
        shown = frames_of(scene, 1)[0].aovs["linear"][16, 16]
        wanted = 2.0 * strength * math.cos(math.radians(theta)) ** exponent * np.array([1, 0.5, 0.25])
        assert shown == pytest.approx(wanted, rel=2e-3, abs=1e-6)


def test_its_settings_are_checked_where_they_are_written(model: Any) -> None:
    scene = scene_of(SCENE % (light_at(0), ""))
    assert scene.material.parameters == model.Parameters()
    with pytest.raises(SceneError, match=r"material.parameters.exponent: must be a number above 0, not '0'"):
        scene_of(SCENE % (light_at(0), ", parameters: {exponent: 0}"))
    with pytest.raises(SceneError, match=r"material.parameters.exponents: unknown key; did you mean"):
        scene_of(SCENE % (light_at(0), ", parameters: {exponents: 3}"))
    with pytest.raises(SceneError, match=r"material.parameters: marschner has no settings of its own here"):
        scene_of("material: {parameters: {exponent: 3}}")
    given = ["model=kajiya_kay", "parameters.strength=0.1", "parameters.exponent=7"]
    own = strandcli.load("hair", [f"material.{one}" for one in given]).material.parameters
    assert own == model.Parameters(exponent=7.0, strength=0.1)
    assert any(stage.stage == "kajiya_kay tables" for stage in make_plan(scene, [1]).used)


def test_a_model_that_lacks_a_part_or_takes_a_name_is_refused() -> None:
    with pytest.raises(UsageError, match="fibre model 'bare': has no `tables`"):
        FIBRES.register(SimpleNamespace(name="bare"))
    with pytest.raises(UsageError, match="fibre model 'chiang': another fibre model has this name"):
        FIBRES.register(SimpleNamespace(name="chiang", tables=None))
    assert FIBRES.names()[:2] == ("marschner", "chiang")
    with pytest.raises(SceneError, match=r"material.model: must be one of marschner, chiang.*not 'kajiya'"):
        scene_of("material: {model: kajiya}")


def test_the_text_of_a_models_module_is_part_of_the_kernels_key(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two classes of one name and layout have one signature, but kernels of their own."""
    monkeypatch.syspath_prepend(str(tmp_path))
    found = []
    for module in ("first_fibre", "second_fibre"):
        (tmp_path / f"{module}.py").write_text(f"from {module}_part import LOBE\n")
        (tmp_path / f"{module}_part.py").write_text(f"LOBE = '{module}'\n")
        monkeypatch.setitem(__import__("sys").modules, module, SimpleNamespace(__file__=str(tmp_path / f"{module}.py")))
        kind = namedtuple("Arrays", "numbers", module=module)
        found.append(typeof(kind(np.zeros(2, np.float32))))
    assert str(found[0]) == str(found[1])
    one, two = (sources.digests_of_types((None, kind)) for kind in found)
    assert len(one) == len(two) == 1
    assert one != two
    assert sources.digests_of_types((typeof(np.zeros(2)), typeof((1, 2)))) == ()
