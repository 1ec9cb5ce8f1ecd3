"""Dual scattering: energy of its tables, limits of its kernel, that pale hair glows; and what strands absorb."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from strand_kit import frames_of, scene_of
from strandcli.draw.fibre import chiang, dual, pigment
from strandcli.draw.fibre.kernels import dual as kernel
from strandcli.draw.fibre.pigment import absorption_of
from strandcli.draw.lighting.palette import Palette, tint_table
from strandcli.jit import function
from strandcli.scene.model import PIGMENTS, Material
from tests.draw.shadows.test_opacity import PICTURE

ONE, ZERO = np.float32(1), np.float32(0)
SIDE = np.float32(np.sqrt(0.5))
"""cos φ at which the second harmonic is 0."""


@function
def angles(*numbers):
    return kernel.angles(*numbers)


@function
def lobes(*numbers):
    return kernel.lobes(*numbers)


@function
def scattered(passed, left, direct, cos_phi, lobes, streams, round_about, tone):
    return kernel.scattered(passed, left, direct, cos_phi, lobes, streams, round_about, tone)


def single(numbers: Iterable[float]) -> list[np.float32]:
    """What a kernel returns comes as Python's floats."""
    return [np.float32(number) for number in numbers]


def rows(**settings: object) -> np.ndarray:
    return dual.build_tables(Material(model="chiang", **settings), 0.3).rows  # type: ignore[arg-type]


@cache
def rows_of(settings: tuple[tuple[str, object], ...]) -> np.ndarray:
    """The same, kept."""
    return rows(**dict(settings))


def streams(row: np.ndarray) -> tuple[np.ndarray, ...]:
    """k, c, k₀, s_f and s_b in rgb, that a row of the tables is the solution for."""
    decay, mirror, beam, on, behind = row[:15].astype(np.float64).reshape(5, 3)
    k = decay * (1 + mirror**2) / (1 - mirror**2)
    c = 2 * decay * mirror / (1 - mirror**2)
    return k, c, beam, (k - beam) * on - c * behind, (k + beam) * behind - c * on


@pytest.mark.parametrize("place", [0, 20])
@pytest.mark.parametrize("pigment", ["white", "brown"])
def test_the_streams_take_and_give_what_a_strand_scatters(pigment: str, place: int) -> None:
    """Against sums over the azimuthal lobes themselves, far finer: nothing is lost but what a strand absorbs."""
    material = Material(model="chiang", pigment=pigment)
    theta = np.linspace(0, 0.5 * np.pi, len(rows()))[place : place + 1]
    sigma = absorption_of(material, 0.3)
    n = chiang.azimuthal(theta, 2049, material.eta, sigma, chiang.logistic_scale(material.beta_n))[0][0]
    phi = np.linspace(0, np.pi, 2049)
    n = n[:, :1] + n[:, 1:4] + n[:, 4:7] + n[:, 7:10]

    def whole(weight: np.ndarray) -> np.ndarray:
        return 2 * np.trapezoid(n * weight[:, None], phi, axis=0)

    back, every = whole((phi < np.pi / 2).astype(float)), np.minimum(whole(np.ones_like(phi)), 0.999)
    k, c, beam, on, behind = streams(rows(pigment=pigment)[place])
    turned = np.sqrt(0.5) * whole(1 + np.cos(phi))
    np.testing.assert_allclose(c, turned, rtol=0.01)
    np.testing.assert_allclose(k - c, np.sqrt(2) * (1 - every), rtol=0.02, atol=2e-3)
    np.testing.assert_allclose(behind, back, rtol=0.02, atol=1e-3)
    np.testing.assert_allclose(on + behind + 1 - beam, every, rtol=0.02)
    assert (np.abs(1 - whole(np.cos(2 * phi)) - beam) < 0.03).all()


@pytest.mark.parametrize("row", [0, 1])
def test_the_streams_are_those_of_light_in_layers(row: int) -> None:
    """Against strands met one thin layer after the other, there and back until nothing changes."""
    table = rows(pigment=("blond", "brown")[row])[12]
    numbers = table[0:15:3]
    k, c, beam, on, behind = (float(number[0]) for number in streams(table))
    layers, depth = 1000, 3.0
    step = depth / layers
    straight = np.exp(-beam * step * np.arange(layers + 1))
    down, up = np.zeros(layers + 1), np.zeros(layers + 1)
    for _ in range(20):
        for i in range(layers):
            down[i + 1] = down[i] + step * (c * up[i + 1] - k * down[i] + on * straight[i])
        for i in range(layers, 0, -1):
            up[i - 1] = up[i] + step * (c * down[i - 1] - k * up[i] + behind * straight[i])
    for tau in (0.0, 0.75, 2.4, 3.0):
        at = round(tau / step)
        t, left, none = np.float32(tau), np.float32(depth - tau), np.float32(np.exp(-tau))
        ahead = scattered(t, left, none, SIDE, (ZERO, ONE), tuple(numbers), (ONE, ZERO), ONE)
        back = scattered(t, left, none, SIDE, (ONE, ZERO), tuple(numbers), (ONE, ZERO), ONE)
        assert float(ahead) == pytest.approx(np.sqrt(2) * down[at] + straight[at] - np.exp(-tau), abs=4e-3)
        assert float(back) == pytest.approx(np.sqrt(2) * up[at], abs=4e-3)


def test_white_strands_scatter_all_and_deep_hair_of_them_sends_back_nearly_all() -> None:
    white = rows(colour=(1.0, 1.0, 1.0))
    np.testing.assert_allclose(2 * np.pi * white[:, kernel.ROUND], 1.0, atol=2e-3)
    assert (white[:-1, kernel.MIRROR] > 0.8).all()


def test_a_strand_alone_gets_no_light_from_others_and_one_behind_very_many_none_at_all() -> None:
    numbers = rows(pigment="blond")[10, 0:15:3]
    alone = scattered(ZERO, ZERO, ONE, ZERO, (ONE, ONE), tuple(numbers), (ONE, ONE), ONE)
    assert float(alone) == pytest.approx(0, abs=1e-6)
    deep = scattered(np.float32(200), ZERO, ZERO, ZERO, (ONE, ONE), tuple(numbers), (ONE, ONE), ONE)
    assert float(deep) < 1e-6


@given(
    st.lists(st.floats(-1, 1, width=32), min_size=9, max_size=9),
    st.floats(0, 1e4, width=32),
    st.floats(0, 1e4, width=32),
    st.sampled_from([{"pigment": "white"}, {"pigment": "black", "grey": 0.5}, {"beta_m": 0.001, "beta_n": 0.001}]),
)
def test_whatever_is_asked_light_is_a_number(
    ways: list[float], passed: float, left: float, settings: dict[str, object]
) -> None:
    table = rows_of(tuple(settings.items()))
    assert np.isfinite(table).all()
    tangent, source, eye = (tuple(one) for one in np.array(ways, np.float32).reshape(3, 3))
    *sines, cos_phi, place = single(angles(tangent, source, eye, len(table)))
    row = table[int(place)]
    tau = np.float32(passed)
    back, through = single(lobes(*sines, tau, *row[21:]))
    light = scattered(
        tau, np.float32(left), np.float32(np.exp(-passed)), cos_phi, (back, through), tuple(row[0:15:3]),
        tuple(row[15:21:3]), ONE,
    )  # fmt: skip
    assert np.isfinite(light)
    assert light >= 0


def test_pale_hair_glows_and_black_hair_does_not() -> None:
    def brightness(pigment: str, scatter: str) -> float:
        text = (PICTURE % (scatter, "opacity", "opacity")).replace("blond", pigment)
        text = text.replace("scatter:", "diffuse: 0, scatter:").replace("strands: 400", "strands: 2000")
        image = frames_of(scene_of(text), 1)[0].image
        return float(image[20:40, 25:55].mean())

    pale = brightness("platinum", "dual") - brightness("platinum", "diffuse")
    dark = brightness("black", "dual") - brightness("black", "diffuse")
    assert pale > 4
    assert abs(dark) < 0.2 * pale


@pytest.mark.parametrize("pigment", ["white", "brown"])
def test_what_is_behind_strands_gets_all_that_the_streams_bring(pigment: str) -> None:
    """Against the streams where the layer ends, τ' = 0, and against light that is lost by absorption alone."""
    material = Material(model="chiang", pigment=pigment)
    mean = dual.streams_of(dual.build_tables(material, material.beta_n))
    for c in range(3):
        numbers = [np.float32(number) for number in mean[:, c]]
        assert float(kernel.through(ZERO, mean, c)) == pytest.approx(1.0, abs=1e-5)
        last = 1.0
        for tau in (0.3, 1.0, 3.0, 8.0):
            t, none = np.float32(tau), np.float32(np.exp(-tau))
            down = scattered(t, ZERO, none, SIDE, (ZERO, ONE), tuple(numbers), (ONE, ZERO), ONE)
            beam = float(np.exp(-numbers[2] * t))
            arrives = float(kernel.through(t, mean, c))
            assert arrives == pytest.approx(beam + (float(down) - (beam - float(none))) / np.sqrt(2), abs=2e-3)
            assert float(none) < arrives < last
            last = arrives
    reds, blues = kernel.through(ONE, mean, 0), kernel.through(ONE, mean, 2)
    assert (reds > blues + 0.01) == (pigment != "white")


B = 0.3


def test_every_pigment_that_a_preset_may_name_is_known() -> None:
    assert set(PIGMENTS) == {"rgb", *pigment.CONCENTRATIONS}


def test_colour_and_absorption_are_inverses() -> None:
    colours = np.array([[0.22, 0.11, 0.05], [0.9, 0.8, 0.7], [1.0, 0.5, 1e-3]])
    np.testing.assert_allclose(pigment.mass_colour(pigment.absorption(colours, B), B), colours, rtol=1e-12)


def test_kinds_of_hair_are_as_dark_and_as_red_as_their_names() -> None:
    colours = {name: pigment.colour_of(Material(pigment=name), B) for name in pigment.CONCENTRATIONS}
    dark_to_pale = ["black", "dark_brown", "brown", "light_brown", "dark_blond", "blond", "platinum", "white"]
    luminance = [colours[name].mean() for name in dark_to_pale]
    assert (np.diff(luminance) > 0).all()
    redness = {name: colour[0] / colour[2] for name, colour in colours.items()}
    assert redness["red"] > redness["light_brown"] > redness["blond"] > redness["white"]
    assert colours["white"].min() > 0.6


def test_a_concentration_that_is_written_replaces_that_of_the_kind() -> None:
    kind = Material(pigment="brown")
    more = Material(pigment="brown", pheomelanin=1.0)
    eumelanin, pheomelanin = pigment.CONCENTRATIONS["brown"]
    expected = pigment.absorption_of(kind, B) + (1.0 - pheomelanin) * pigment.PHEOMELANIN
    np.testing.assert_allclose(pigment.absorption_of(more, B), expected)
    alone = Material(eumelanin=eumelanin, colour=(1.0, 0.0, 0.0))
    np.testing.assert_allclose(pigment.absorption_of(alone, B), eumelanin * pigment.EUMELANIN)


@pytest.mark.parametrize("kind", [{"pigment": "red"}, {"colour": (0.4, 0.2, 0.1)}], ids=["melanin", "rgb"])
def test_strands_differ_by_their_tone_and_tips_from_roots(kind: dict[str, object]) -> None:
    material = Material(**kind, tip_colour=(0.6, 0.5, 0.4), colour_variation=0.5)  # type: ignore[arg-type]
    table = tint_table(material, B, pigment.absorption_of(material, B))
    middle = table.shape[1] // 2
    np.testing.assert_allclose(table[0, middle, :3], pigment.colour_of(material, B), rtol=1e-6)
    np.testing.assert_allclose(table[0, middle, 3:], 0.0, atol=1e-6)
    np.testing.assert_allclose(table[-1, middle, :3], (0.6, 0.5, 0.4), rtol=1e-6)
    assert (np.diff(table[:, :, 0], axis=1) > 0).all()
    assert (np.diff(table[:, :, 3:], axis=1) < 0).all()


def test_a_share_of_strands_is_grey() -> None:
    palette = Palette(Material(model="chiang", pigment="black", grey=0.25))
    assert len(palette.arrays.paths) > 0
    white = (palette.tint[0, :, :3] == 1.0).all(-1)
    assert white.mean() == pytest.approx(0.25, abs=0.02)
    assert Palette(Material(pigment="black")).tint is None


def test_strands_without_pigment_may_have_a_colour_of_their_own() -> None:
    straw = (0.5, 0.35, 0.1)
    palette = Palette(Material(model="chiang", colour=(0.1, 0.3, 0.05), grey=0.25, grey_colour=straw))
    assert len(palette.arrays.paths) > 0
    other = np.isclose(palette.tint[:, :, :3], straw, atol=1e-6).all(-1)
    assert other.mean() == pytest.approx(0.25, abs=0.02)
    base, own = (pigment.absorption(colour, 0.3) for colour in ((0.1, 0.3, 0.05), straw))
    np.testing.assert_allclose(palette.tint[other][:, 3:] + base, np.tile(own, (other.sum(), 1)), rtol=1e-5)
