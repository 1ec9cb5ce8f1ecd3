"""The float64 hair reference against closed forms and traced rays."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.reference import marschner as ref

DEGREES = math.pi / 180


@pytest.mark.parametrize("eta", [1.1, 1.55, 2.5])
def test_two_index_reflectance_is_fresnels_at_the_true_angle(eta):
    """Bravais' two indices restate the plain dielectric whose angle of incidence has the cosine cos θ_d cos γ."""
    gamma = np.linspace(0, 1.55, 40)
    for theta_d in np.linspace(0, 1.5, 10):
        cos_i = math.cos(theta_d) * np.cos(gamma)
        cos_t = np.sqrt(1 - (1 - cos_i**2) / eta**2)
        s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
        p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
        assert ref.fresnel(eta, theta_d, gamma) == pytest.approx(0.5 * (s * s + p * p), abs=1e-12)


def refract(d, n, ratio):
    """Snell's law for vectors: n against d, ``ratio`` the index before over the one behind."""
    c = -d @ n
    return ratio * d + (ratio * c - math.sqrt(1 - ratio**2 * (1 - c * c))) * n


@pytest.mark.parametrize("theta", [0.0, 0.4, 1.1])
@pytest.mark.parametrize("h", [-0.95, -0.3, 0.0, 0.6])
def test_a_traced_ray_confirms_the_chord_and_the_exit_angles(theta, h):
    """Through a unit cylinder about z in three dimensions: the length inside, and where TT and TRT leave."""
    eta = 1.55
    d = np.array([-math.cos(theta), 0.0, -math.sin(theta)])
    at = np.array([math.sqrt(1 - h * h), -h, 0.0])  # a positive offset lies on the side that Φ turns away from
    inside = refract(d, at, 1 / eta)
    directions, normal = [], at
    for _ in range(2):
        length = -2 * (normal[:2] @ inside[:2]) / (inside[:2] @ inside[:2])
        normal = np.append(normal[:2] + length * inside[:2], 0.0)
        directions.append(refract(inside, -normal, eta))
        inside = inside - 2 * (inside @ normal) * normal
    fibre = ref.Fibre(eta, 0.0, 0.1, 0.1, 0.7)
    gamma = np.array([math.asin(h)])
    clear = ref.Fibre(eta, 0.0, 0.1, 0.1, 0.0)
    for lobe in (1, 2):
        took = ref.attenuation(lobe, fibre, theta, gamma)[0] / ref.attenuation(lobe, clear, theta, gamma)[0]
        assert -math.log(took) / 0.7 == pytest.approx(lobe * length, rel=1e-9)
        left = math.atan2(directions[lobe - 1][1], directions[lobe - 1][0])
        difference = left - ref.exit_angle(lobe, eta, theta, gamma)[0]
        assert math.remainder(difference, 2 * math.pi) == pytest.approx(0, abs=1e-9)


def test_azimuthal_functions_sum_to_what_leaves_the_cylinder():
    """With no absorption ∫ N dφ over R, TT and TRT is 1 − ½ ∫ F² (1 − F) dh: only later lobes are missing."""
    fibre = ref.Fibre(1.55, 0.0, 0.1, 0.2, 0.0)
    phi = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    gamma, weights = ref.quadrature(32)
    for theta_d in (0.0, 0.7, 1.3):
        whole = sum(ref.azimuthal(p, fibre, theta_d, phi).mean() * 2 * np.pi for p in range(3))
        f = ref.fresnel(1.55, theta_d, gamma)
        assert whole == pytest.approx(1 - weights @ (f**2 * (1 - f)), abs=1e-9)


def test_shifted_lobes_make_at_most_an_eighth_more_light_than_falls_in():
    """cos² θ_v / cos² θ_d is not 1 off the mirror direction: at α = −7.5° the model returns up to 1.11 at 60°."""
    worst = max(
        ref.albedo(ref.Fibre(1.55, -7.5 * DEGREES, beta * DEGREES, 0.2, 0.0), theta * DEGREES, steps=400)
        for beta in (1, 3, 7.5, 20)
        for theta in range(-75, 76, 15)
    )
    assert 1.05 < worst < 1.125
