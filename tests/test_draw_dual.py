"""Dual scattering: energy of its tables, limits of its kernel, and that pale hair glows."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strand_kit import frames_of, scene_of
from test_draw_opacity import PICTURE

from strandcli.draw import chiang, dual
from strandcli.draw.kernels import dual as kernel
from strandcli.draw.pigment import absorption_of
from strandcli.draw.shading import Palette
from strandcli.scene.model import Material

ONE, ZERO = np.float32(1), np.float32(0)


def single(numbers: Iterable[float]) -> list[np.float32]:
    """What a kernel returns comes as Python's floats."""
    return [np.float32(number) for number in numbers]


def rows(**settings: object) -> np.ndarray:
    return dual.build_tables(Material(model="chiang", **settings), 0.3).rows  # type: ignore[arg-type]


def streams(row: np.ndarray) -> tuple[np.ndarray, ...]:
    """k₁, c₁, c₂ and k₂ in rgb, that the solution in a row of the tables is one for."""
    fall, gap, mirror, ratio = row[:12].astype(np.float64).reshape(4, 3)
    low, high, other = -fall, gap - fall, mirror / ratio
    c1 = gap / (other - mirror)
    k2 = (high * other - low * mirror) / (other - mirror)
    return c1 * mirror - low, c1, mirror * (k2 - low), k2


@pytest.mark.parametrize("place", [0, 20, 40])
@pytest.mark.parametrize("pigment", ["white", "blond", "brown"])
def test_the_streams_take_and_give_what_a_strand_scatters(pigment: str, place: int) -> None:
    """Against sums over the azimuthal lobes themselves."""
    material = Material(model="chiang", pigment=pigment)
    theta = np.linspace(0, 0.5 * np.pi, len(rows()))[place : place + 1]
    sigma = absorption_of(material, 0.3)
    n = chiang.azimuthal(theta, 2049, material.eta, sigma, chiang.logistic_scale(material.beta_n))[0][0]
    phi = np.linspace(0, np.pi, 2049)
    n = n[:, :1] + n[:, 1:4] + n[:, 4:7] + n[:, 7:10]

    def whole(weight: np.ndarray) -> np.ndarray:
        return 2 * np.trapezoid(n * weight[:, None], phi, axis=0)

    back, on = whole((phi < np.pi / 2).astype(float)), whole((phi >= np.pi / 2).astype(float))
    lost = np.maximum(1 - back - on, 0.001)
    turned = 0.5 * np.pi * whole(1 - phi / np.pi)
    k1, c1, c2, k2 = streams(rows(pigment=pigment)[place])
    np.testing.assert_allclose(c1, turned, rtol=0.01)
    np.testing.assert_allclose(c2, back, rtol=0.01)
    np.testing.assert_allclose(k1 - c2, lost, rtol=0.02, atol=3e-4)
    np.testing.assert_allclose(k2 - c1, 0.5 * np.pi * lost, rtol=0.02, atol=5e-4)


def test_both_streams_are_those_of_light_in_layers() -> None:
    """Against strands met one thin layer after the other, there and back until nothing changes."""
    a_f, a_b, turned = 0.8, 0.12, 0.2
    k1, c1, c2, k2 = 1 - a_f, 0.5 * np.pi * turned, a_b, 0.5 * np.pi * (1 - a_f - a_b + turned)
    values, vectors = np.linalg.eig(np.array([[-k1, c1], [-c2, k2]]))
    (low, mirror), (high, other) = sorted(zip(values, vectors[1] / vectors[0], strict=True))
    numbers = np.array([-low, high - low, mirror, mirror / other], np.float32)
    layers, depth = 4000, 3.0
    step = depth / layers
    down, up = np.ones(layers + 1), np.zeros(layers + 1)
    for _ in range(60):
        for i in range(layers):
            down[i + 1] = down[i] + step * (c1 * up[i + 1] - k1 * down[i])
        for i in range(layers, 0, -1):
            up[i - 1] = up[i] + step * (c2 * down[i - 1] - k2 * up[i])
    for tau in (0.0, 0.75, 2.4, 3.0):
        at = round(tau / step)
        t, left, none = np.float32(tau), np.float32(depth - tau), np.float32(np.exp(-tau))
        on = kernel.scattered(t, left, none, ONE, ZERO, ONE, *numbers, ONE, ZERO, ONE)
        back = kernel.scattered(t, left, none, ONE, ONE, ZERO, *numbers, ONE, ZERO, ONE)
        assert float(on) == pytest.approx(down[at] - np.exp(-tau), abs=3e-3)
        assert float(back) == pytest.approx(0.5 * np.pi * up[at], abs=3e-3)


def test_white_strands_scatter_all_and_deep_hair_of_them_sends_back_nearly_all() -> None:
    white = rows(colour=(1.0, 1.0, 1.0))
    np.testing.assert_allclose(2 * np.pi * white[:, kernel.ROUND], 1.0, atol=2e-3)
    assert (white[:-1, kernel.MIRROR] > 0.85).all()


def test_darker_strands_stop_more_and_return_less() -> None:
    tables = [rows(pigment=name) for name in ("white", "platinum", "blond", "brown", "black")]
    stopped = [one[:-4, kernel.FALL].mean() for one in tables]
    back = [one[:-4, kernel.MIRROR].mean() for one in tables]
    assert (np.diff(stopped) > 0).all()
    assert (np.diff(back) < 0).all()
    red = rows(pigment="red")[0]
    assert red[kernel.FALL] < red[kernel.FALL + 1] < red[kernel.FALL + 2]


def test_a_strand_alone_gets_no_light_from_others() -> None:
    row = rows(pigment="blond")[10]
    numbers = [row[3 * i] for i in range(4)]
    assert float(kernel.scattered(ZERO, ZERO, ONE, ZERO, ONE, ONE, *numbers, ONE, ONE, ONE)) == pytest.approx(0, abs=1e-6)
    deep = kernel.scattered(np.float32(200), ZERO, ZERO, ZERO, ONE, ONE, *numbers, ONE, ONE, ONE)
    assert float(deep) < 1e-6


@pytest.mark.parametrize("tau", [0.1, 1.0, 4.0])
@pytest.mark.parametrize("a", [0.3, 0.9])
def test_what_comes_through_is_the_mean_over_poissons_numbers(tau: float, a: float) -> None:
    """Of strands that send nothing back."""
    rng = np.random.default_rng(0)
    number = rng.poisson(tau, 400_000)
    expected = np.where(number > 0, a**number, 0.0).mean()
    t = np.float32(tau)
    none = np.float32(np.exp(-tau))
    got = kernel.scattered(t, ONE, none, ZERO, ZERO, ONE, np.float32(1 - a), ONE, ZERO, ZERO, ONE, ZERO, ONE)
    assert float(got) == pytest.approx(expected, rel=0.02)


@given(
    st.lists(st.floats(-1, 1, width=32), min_size=9, max_size=9),
    st.floats(0, 1e4, width=32),
    st.floats(0, 1e4, width=32),
    st.sampled_from([{"pigment": "white"}, {"pigment": "black", "grey": 0.5}, {"beta_m": 0.001, "beta_n": 0.001}]),
)
def test_whatever_is_asked_light_is_a_number(
    ways: list[float], passed: float, left: float, settings: dict[str, object]
) -> None:
    table = TABLES.setdefault(str(settings), rows(**settings))
    assert np.isfinite(table).all()
    *sines, cos_phi, place = single(kernel.angles(*np.array(ways, np.float32), len(table)))
    row = table[int(place)]
    tau = np.float32(passed)
    back, through = single(kernel.lobes(*sines, tau, *row[18:]))
    light = kernel.scattered(
        tau, np.float32(left), np.float32(np.exp(-passed)), cos_phi, back, through, *row[0:18:3], ONE
    )
    assert np.isfinite(light)
    assert light >= 0


TABLES: dict[str, np.ndarray] = {}


def test_it_is_left_out_where_nothing_counts_strands() -> None:
    material = Material(model="chiang", scatter="dual")
    assert Palette(material).dual is None
    assert Palette(material, True).dual is not None
    assert Palette(Material(model="chiang"), True).dual is None


def test_pale_hair_glows_and_black_hair_does_not() -> None:
    def brightness(pigment: str, scatter: str) -> float:
        text = (PICTURE % (scatter, "opacity", "opacity")).replace("blond", pigment)
        text = text.replace("scatter:", "diffuse: 0, scatter:")
        image = frames_of(scene_of(text), 1)[0].image
        assert image is not None
        return float(image[20:40, 25:55].mean())

    pale = brightness("platinum", "dual") - brightness("platinum", "diffuse")
    dark = brightness("black", "dual") - brightness("black", "diffuse")
    assert pale > 8
    assert abs(dark) < 0.2 * pale
