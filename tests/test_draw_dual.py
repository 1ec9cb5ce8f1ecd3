"""Dual scattering: energy of its tables, limits of its kernel, and that pale hair glows."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strand_kit import frames_of, scene_of
from test_draw_opacity import PICTURE

from strandcli.draw import dual
from strandcli.draw.kernels import dual as kernel
from strandcli.draw.shading import Palette
from strandcli.scene.model import Material

ONE, ZERO = np.float32(1), np.float32(0)


def single(numbers: Iterable[float]) -> list[np.float32]:
    """What a kernel returns comes as Python's floats."""
    return [np.float32(number) for number in numbers]


def rows(**settings: object) -> np.ndarray:
    return dual.build_tables(Material(model="chiang", **settings), 0.3).rows  # type: ignore[arg-type]


def test_white_strands_send_everything_forward_or_back() -> None:
    """a_f + a_b = 1; all that is scattered is 1; the paper's series for what comes back stays below 1."""
    white = rows(colour=(1.0, 1.0, 1.0))
    np.testing.assert_allclose(2 * np.pi * white[:, kernel.ROUND], 1.0, atol=2e-3)
    a_f = 1 - white[:-1, kernel.STOPPED]
    assert ((a_f[:45] > 0.6) & (a_f[:45] < 1)).all()  # nearer to the strand's own direction more is reflected
    a_b = 1 - a_f
    series = a_b * a_f**2 / (1 - a_f**2) + a_b**3 * a_f**2 / (1 - a_f**2) ** 3
    np.testing.assert_allclose(white[:-1, kernel.BACKWARD], np.minimum(series, 1), rtol=1e-3)


def test_darker_strands_stop_more_and_return_less() -> None:
    tables = [rows(pigment=name) for name in ("white", "platinum", "blond", "brown", "black")]
    stopped = [one[:-4, kernel.STOPPED].mean() for one in tables]
    back = [one[:-4, kernel.BACKWARD].mean() for one in tables]
    assert (np.diff(stopped) > 0).all()
    assert (np.diff(back) < 0).all()
    red = rows(pigment="red")[0]
    assert red[kernel.STOPPED] < red[kernel.STOPPED + 1] < red[kernel.STOPPED + 2]


def test_with_no_strand_in_the_way_only_the_strands_about_add_light() -> None:
    numbers = np.array([0.3, 0.4, 0.1, 0.05], np.float32)
    direct = kernel.scattered(ZERO, ONE, ZERO, ONE, ONE, *numbers, ONE)
    assert float(direct) == pytest.approx(0.7 * 0.4 / (2 * np.pi), rel=1e-6)
    deep = kernel.scattered(np.float32(80), ZERO, ZERO, ONE, ONE, *numbers, ONE)
    assert float(deep) < 1e-10


@pytest.mark.parametrize("tau", [0.1, 1.0, 4.0])
@pytest.mark.parametrize("a", [0.3, 0.9])
def test_what_comes_through_is_the_mean_over_poissons_numbers(tau: float, a: float) -> None:
    rng = np.random.default_rng(0)
    number = rng.poisson(tau, 400_000)
    expected = 0.7 * np.where(number > 0, a**number, 0.0).mean()
    t = np.float32(tau)
    none = np.float32(np.exp(-tau))
    got = kernel.scattered(t, none, ZERO, ZERO, ONE, np.float32(1 - a), ZERO, ONE, ZERO, ONE)
    assert float(got) == pytest.approx(expected, rel=0.02)


@given(
    st.lists(st.floats(-1, 1, width=32), min_size=9, max_size=9),
    st.floats(0, 1e4, width=32),
    st.sampled_from([{"pigment": "white"}, {"pigment": "black", "grey": 0.5}, {"beta_m": 0.001, "beta_n": 0.001}]),
)
def test_whatever_is_asked_light_is_a_number(ways: list[float], passed: float, settings: dict[str, object]) -> None:
    table = TABLES.setdefault(str(settings), rows(**settings))
    assert np.isfinite(table).all()
    *sines, cos_phi, place = single(kernel.angles(*np.array(ways, np.float32), len(table)))
    row = table[int(place)]
    tau = np.float32(passed)
    back, through = single(kernel.lobes(*sines, tau, *row[[12, 13, 14, 15]]))
    light = kernel.scattered(tau, np.float32(np.exp(-passed)), cos_phi, back, through, *row[[0, 3, 6, 9]], ONE)
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
