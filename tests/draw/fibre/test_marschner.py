"""The hair tables and the kernel that reads them, against the float64 reference; and a model from outside."""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import typeof

import strandcli
from fibre_kit import scattered
from strand_kit import frames_of, scene_of
from strandcli.common.registry import FIBRES
from strandcli.draw.fibre import marschner as tables_of
from strandcli.draw.fibre.kernels.dual import kajiya_diffuse
from strandcli.draw.fibre.pigment import absorption
from strandcli.errors import UsageError
from strandcli.jit import sources
from strandcli.plan import make_plan
from strandcli.scene import SceneError
from strandcli.scene.model import Material
from tests.reference import marschner as ref

BROWN = Material(colour=(0.4, 0.15, 0.03))
DEGREES = math.pi / 180


def direction(theta, phi):
    """Unit vectors in degrees about a strand that points along +x."""
    theta, phi = np.broadcast_arrays(np.asarray(theta, float) * DEGREES, np.asarray(phi, float) * DEGREES)
    return np.stack([np.sin(theta), np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi)], -1)


def evaluate(tables, lights, views, extra=(0, 0, 0), t=(1, 0, 0)):
    return scattered(tables.arrays, t, lights, views, extra).astype(np.float64)


def at(tables, theta_l, theta_v, phi, extra=(0, 0, 0)):
    theta_l, theta_v, phi = np.broadcast_arrays(*np.atleast_1d(theta_l, theta_v, phi))
    return evaluate(tables, direction(theta_l, 20.0), direction(theta_v, 20.0 + phi), extra)


def fibre(material, sigma):
    angles = [v * DEGREES for v in (material.alpha, material.beta, material.azimuthal)]
    return ref.Fibre(material.eta, *angles, sigma)


def only(material, lobe):
    """Tables in which the other two lobes are dark."""
    tables = tables_of.build_tables(material)
    nodes = np.zeros_like(tables.nodes)
    channels = (slice(0, 1), slice(1, 4), slice(4, 7))[lobe]
    nodes[..., channels] = tables.nodes[..., channels]
    return replace(tables, nodes=nodes)


# --- the tables against quadrature ---


@pytest.mark.parametrize("azimuthal", [5, 12, 40])
def test_interpolated_tables_against_quadrature(azimuthal):
    """Up to θ_d = 80°, RMS and pointwise above a tenth and a hundredth of a lobe's peak. Measured: R .22 %, .4 %, .4 %;
    TT .03 %, .2 %, .8 %; TRT .25 %, 1 %, 3.7 %."""
    material = replace(BROWN, azimuthal=float(azimuthal))
    tables = tables_of.build_tables(material)
    rng = np.random.default_rng(7)
    theta_d, phi = np.sort(rng.uniform(0, 80, 30)), rng.uniform(0, 180, 100)
    lights, views = direction(-theta_d[:, None], 0 * phi), direction(theta_d[:, None], phi)
    peaks = [0.5 / (math.sqrt(2 * math.pi) * w * material.beta * DEGREES) for w in (1, 0.5, 2)]
    for lobe, (rms, ten, one) in enumerate([(0.003, 0.005, 0.005), (0.0005, 0.003, 0.01), (0.003, 0.012, 0.045)]):
        dark = only(replace(material, alpha=0.0), lobe)
        got = evaluate(dark, lights.reshape(-1, 3), views.reshape(-1, 3)).reshape(30, 100, 3)
        got *= np.cos(theta_d * DEGREES)[:, None, None] / peaks[lobe]
        for channel, sigma in enumerate(tables.absorption):
            exact = np.array([ref.azimuthal(lobe, fibre(material, sigma), d * DEGREES, phi * DEGREES) for d in theta_d])
            error = np.abs(got[..., channel] - exact)
            assert np.sqrt(np.mean(error**2) / np.mean(exact**2)) < rms
            assert (error / exact)[exact > 0.1 * exact.max()].max() < ten
            assert (error / exact)[exact > 0.01 * exact.max()].max() < one


def test_the_whole_function_against_the_reference():
    tables = tables_of.build_tables(BROWN)
    rng = np.random.default_rng(3)
    peak = at(tables, 0, np.arange(-90, 90, 2), 180).max(axis=0)
    for theta_l, theta_v in rng.uniform(-70, 70, (25, 2)):
        phi = rng.uniform(0, 180, 40)
        got = at(tables, theta_l, theta_v, phi)
        for c, sigma in enumerate(tables.absorption):
            exact = ref.scattering(fibre(BROWN, sigma), theta_l * DEGREES, theta_v * DEGREES, phi * DEGREES)
            assert got[:, c] == pytest.approx(exact, rel=0.04, abs=2e-4 * peak[c])


# --- the shape of the lobes ---


@pytest.mark.parametrize(("lobe", "share"), [(0, 2.0), (1, -1.0), (2, -3.0)])
@pytest.mark.parametrize("theta_l", [0, 20])
def test_peaks_stand_at_minus_theta_plus_twice_the_shift(lobe, share, theta_l):
    """R at −θ_l + 2α, TT at −θ_l − α, TRT at −θ_l − 3α, within 1°; at a narrow β, as 1/cos² θ_d leans wide lobes."""
    tables = only(replace(BROWN, beta=2.0), lobe)
    theta_v = np.arange(-85, 85, 0.1)
    phi = 180.0 if lobe == 1 else 0.0
    found = theta_v[np.argmax(at(tables, theta_l, theta_v, phi)[:, 0])]
    assert found == pytest.approx(-theta_l + share * BROWN.alpha, abs=1.0)


def test_reciprocity():
    """S, that is the result over the light's cosine, does not tell light from eye."""
    tables = tables_of.build_tables(BROWN)
    rng = np.random.default_rng(1)
    theta_l, theta_v = rng.uniform(-75, 75, (2, 200))
    phi = rng.uniform(5, 175, 200)
    there = at(tables, theta_l, theta_v, phi) / np.cos(theta_l * DEGREES)[:, None]
    back = at(tables, theta_v, theta_l, phi) / np.cos(theta_v * DEGREES)[:, None]
    assert there == pytest.approx(back, rel=5e-4)


# --- absorption and colour ---


def test_roughness_conversion_matches_the_deviation_of_the_logistic():
    for degrees in (2.0, 12.0, 30.0, 60.0):
        beta = tables_of.azimuthal_beta(degrees)
        scale = math.sqrt(math.pi / 8) * (0.265 * beta + 1.194 * beta**2 + 5.372 * beta**22)
        x = np.linspace(-60, 60, 200_001) * scale
        density = 1 / (4 * scale * np.cosh(x / (2 * scale)) ** 2)
        deviation = math.sqrt(np.sum(density * x * x) * (x[1] - x[0]))
        assert deviation / DEGREES == pytest.approx(degrees, rel=1e-4)


@pytest.mark.parametrize(("ratio", "bound"), [(1.3, 0.01), (0.4, 0.05)])
def test_a_strand_of_another_colour_against_tables_of_that_colour(ratio, bound):
    """Through mean paths: within 1 % of the peak for colours .7 to 1.3 times the base, 5 % for .4 to 1.8 times."""
    base = tables_of.build_tables(replace(BROWN, colour_variation=0.1))
    colour = tuple(ratio * c for c in BROWN.colour)
    exact = tables_of.build_tables(replace(BROWN, colour=colour))
    extra = absorption(colour, tables_of.azimuthal_beta(BROWN.azimuthal)) - base.absorption
    theta_v, phi = (a.ravel() for a in np.meshgrid(np.arange(-70, 71, 10), np.arange(0, 181, 5)))
    got, wanted = at(base, 15, theta_v, phi, extra), at(exact, 15, theta_v, phi)
    assert np.abs(got - wanted).max() < bound * wanted.max()


NUMBERS = st.floats(width=32, allow_nan=True, allow_infinity=True)
UNITS = st.sampled_from([0.0, 1.0, -1.0, 1.0000002, 0.70710677, 1e-20, 1e-7])
ROUGH = tables_of.build_tables(Material(colour_variation=0.2))
SHARP = tables_of.build_tables(Material(beta=0.1, azimuthal=1.0, colour_variation=0.2))


@settings(max_examples=100, deadline=None)
@given(st.lists(NUMBERS | UNITS, min_size=12, max_size=12), st.sampled_from([ROUGH, SHARP]))
def test_finite_and_not_negative_whatever_is_passed(numbers, tables):
    arguments = [np.float32(x) for x in numbers]
    with np.errstate(all="ignore"):
        ways = [arguments[i : i + 3] for i in (0, 3, 6)]
        result = scattered(tables.arrays, *ways, arguments[9:])[0]
        plain = scattered(replace(tables, paths=None).arrays, *ways)[0]
        diffuse = kajiya_diffuse(*arguments[:6])
    assert np.isfinite([*result, *plain, diffuse]).all()
    assert min(*result, *plain, diffuse) >= 0


@pytest.mark.parametrize("tables", [ROUGH, SHARP])
def test_degenerate_directions(tables):
    """Light or eye along the strand, both, opposite, and a hair's breadth from it."""
    near = direction([90, -90, 89.99, -89.99, 89.9, 60, 0], 0)
    lights, views = np.repeat(near, len(near), 0), np.tile(near, (len(near), 1))
    result = evaluate(tables, lights, views)
    assert np.isfinite(result).all()
    assert (result >= 0).all()
    assert (result < 1e4).all()
    along_the_strand = np.abs(lights[:, 0]) == 1
    assert (result[along_the_strand] == 0).all()


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
