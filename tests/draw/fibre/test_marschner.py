"""The hair tables and the kernel that reads them, against the float64 reference and by their properties."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fibre_kit import scattered
from strandcli.draw.fibre import marschner as tables_of
from strandcli.draw.fibre.kernels.dual import kajiya_diffuse
from strandcli.draw.fibre.pigment import absorption
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
