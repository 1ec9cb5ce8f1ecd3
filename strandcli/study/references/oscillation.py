"""Small oscillations: frequencies and decay of a clamped beam, and of hair that swings as in a film.

The exact modes are closed forms; those of a run are fitted.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from .base import Array, Case, Errors, G, Reference, Track, groom, preset

COUNT = 3
"""Modes that are compared."""
STEPS = (1 / 60, 1 / 120, 1 / 240, 1 / 480)
"""Steps in seconds to try: a swing asks for some dozens."""
Swing = tuple[float, float]
"""An angular frequency ω and a decay rate λ, both 1/s."""
DECAYS = (0.0, 0.01, 0.03, 0.1, 0.3)
"""Decay rates over the frequency, from which a fit may start."""
SLOWEST = 2 * math.pi
"""Angular frequency of the beam's first mode, rad/s: a swing a second."""
LIGHT = 0.02
"""Γ of the beam: so little gravity that its swing stays in the linear range."""
LENGTH = 0.25
"""Metres, of hair to the shoulders; at 24 steps a second ω h is .31, 20 steps a cycle."""
LET_GO = math.pi / 36
"""Of that hair, radians: five degrees, for frequencies grow with the square of it."""


@dataclass(frozen=True)
class Modes:
    """The slowest modes of a strand of length 1."""

    frequencies: Array
    """(m,) angular, ascending, in the problem's own unit."""
    shapes: Callable[[Array], Array]
    """Displacements (p, m) at places (p,) from the root, 0, to the tip, 1; of a mean square of one and orthogonal."""

    def shares(self, positions: Array) -> Array:
        """(T, m): how much of each mode is in displacements (T, p) at p even places from the root, 0, to the tip."""
        places = np.linspace(0, 1, positions.shape[1])
        weights = np.full(len(places), 1.0)
        weights[[0, -1]] = 0.5  # of the trapezoidal rule, and the masses of a strand's particles as well
        return np.asarray(positions @ (weights[:, None] * self.shapes(places)) / (len(places) - 1))


@cache
def beam(count: int = COUNT) -> Modes:
    """Clamped at the root, free at the tip: w⁗ = ω² w in units of √(B / (ρ A L⁴)); ω = β², cos β cosh β = −1."""
    beta = np.asarray((np.arange(count) + 0.5) * math.pi, np.float64)
    for _ in range(20):
        beta -= (np.cos(beta) + 1 / np.cosh(beta)) / (-np.sin(beta) - np.tanh(beta) / np.cosh(beta))

    def shapes(places: Array) -> Array:
        x = places[:, None] * beta
        sigma = (np.cosh(beta) + np.cos(beta)) / (np.sinh(beta) + np.sin(beta))
        return np.asarray(np.cosh(x) - np.cos(x) - sigma * (np.sinh(x) - np.sin(x)))

    return Modes(beta**2, shapes)


@cache
def chain(count: int = COUNT) -> Modes:
    """Hanging from its root without stiffness: (t u′)′ = −ω² u with t = 1 − s, in units of √(g / L); J₀(2 ω) = 0, and
    u = J₀(2 ω √t) (Bernoulli 1733)."""
    zeros = np.asarray((np.arange(count) + 0.75) * math.pi, np.float64)
    for _ in range(20):
        zeros += bessel(0, zeros) / bessel(1, zeros)
    return Modes(zeros / 2, lambda places: bessel(0, np.sqrt(1 - places)[:, None] * zeros) / np.abs(bessel(1, zeros)))


def bessel(order: int, x: Array) -> Array:
    """J_n: the mean of cos(n θ − x sin θ)."""
    theta = (np.arange(64) + 0.5) * math.pi / 64
    return np.asarray(np.cos(order * theta - np.asarray(x)[..., None] * np.sin(theta)).mean(-1))


def oscillation(times: Array, values: Array, guess: float, present: Sequence[Swing] = ()) -> Swing | None:
    """The swing of a + e^{−λ t} (b cos ω t + c sin ω t), fitted to values (T,) at times (T,) by least squares; a, b and
    c are eliminated (Golub & Pereyra 1973). ``guess`` is about ω; ``present`` are swings that are in the values as
    well. None where the values hold no such oscillation: fewer than 8 of them, no movement, or one over before it
    swings."""
    if len(times) < 8 or not np.isfinite(values).all() or np.ptp(values) == 0:
        return None
    t = times - times[0]

    def pair(omega: float, decay: float) -> list[Array]:
        size = np.exp(-np.clip(decay * t, -50, 50))
        return [size * np.cos(omega * t), size * np.sin(omega * t)]

    basis = np.stack([np.ones_like(t), *[wave for other in present for wave in pair(*other)]], 1)
    known, _ = np.linalg.qr(basis)
    rest = values - known @ (known.T @ values)
    power = float(rest @ rest)

    def misfit(omega: float, decay: float) -> float:
        waves = np.stack(pair(omega, decay), 1)
        waves -= known @ (known.T @ waves)
        first, second = waves.T / np.maximum(np.sqrt((waves**2).sum(0)), 1e-300)[:, None]
        across = second - (first @ second) * first
        across /= max(float(np.sqrt(across @ across)), 1e-300)
        return power - float((first @ rest) ** 2 + (across @ rest) ** 2)

    best = min((misfit(guess * f, guess * d), guess * f, guess * d) for f in np.geomspace(0.5, 1.5, 61) for d in DECAYS)
    _, omega, decay = best
    size = 0.02 * guess
    while size > 1e-10 * guess:  # a compass search: robust, and nothing else here needs to be fast
        tries = [(omega + size, decay), (omega - size, decay), (omega, decay + size), (omega, decay - size)]
        value, place = min((misfit(*one), one) for one in tries)
        if value < best[0]:
            best, (omega, decay) = (value, *place), place
        else:
            size /= 2
    if abs(decay) > omega or not 0.45 * guess < omega < 1.6 * guess:
        return None
    return float(omega), float(decay)


def errors(modes: Modes, unit: float, track: Track, axis: int) -> Errors:
    """Relative errors of the frequencies of modes, in 1/s by their ``unit``, in the first strand's places along one
    axis of space; ``loss``, the share of the first mode's amplitude that a cycle loses; and ``swing``, which holds both
    errors of the first mode: that of its complex frequency ω + i λ, of which λ should be 0. A discrete strand's modes
    are not quite the exact ones, so that slower modes show in the share of each, and are taken out of it."""
    times, swings = track.times, modes.shares(track.positions[:, 0, :, axis])
    found: list[Swing] = []
    out: Errors = {"swing": None}
    for i, exact in enumerate(modes.frequencies * unit):
        swing = oscillation(times, swings[:, i], float(exact), found) if len(found) == i else None
        if swing is not None:
            found.append(swing)
        out[f"frequency {i + 1}"] = None if swing is None else float(abs(swing[0] / exact - 1))
    out["loss"] = None
    if found:
        omega, decay = found[0]
        exact = float(modes.frequencies[0] * unit)
        out["swing"] = math.hypot(omega - exact, decay) / exact
        out["loss"] = abs(math.expm1(-2 * math.pi * decay / omega))
    return out


def rigidity() -> float:
    """B / (ρ A) that makes the first mode of a beam of a metre as slow as it should be, m⁴/s²."""
    return float((SLOWEST / beam().frequencies[0]) ** 2)


def measure_swing(track: Track) -> Errors:
    """``loss``: share of the first mode's amplitude lost in a cycle; ``frequency 1``; ``swing``: both, as the error of
    a complex frequency; ``growth``: highest rise of the centre of mass above where it was let go, as a share of the
    length, which is energy over m g L: no solver has to tell its velocities."""
    found = errors(chain(), math.sqrt(G / LENGTH), Track(track.times, track.positions / LENGTH), axis=0)
    height = track.positions[:, 0, :, 1]
    centre = ((height[:, 1:] + height[:, :-1]) / 2).mean(1) - height[:, 0]
    rise = max(0.0, float(centre.max() - centre[0]))
    return {name: found[name] for name in ("swing", "loss", "frequency 1")} | {"growth": rise / LENGTH}


BEAM = Reference(
    name="beam", title="frequencies of a clamped beam", metric="swing", unit="of the frequency",
    needs="bending stiffness in physical units, inertia", span=4.0, moving=True, steps=STEPS,
    exact=lambda: {f"β² {i + 1}": float(value) for i, value in enumerate(beam().frequencies)},
    # a level strand of a metre on which gravity sets in, so that every mode swings about its own rest
    case=lambda n: Case(preset(rigidity(), 1, n, gravity=LIGHT * rigidity()), groom([[1, 0, 0]], [1.0])),
    measure=lambda track: errors(beam(), math.sqrt(rigidity()), track, axis=1),
)  # fmt: skip
SWING = Reference(
    name="swing", title="hair that swings at the steps of a film", metric="swing", unit="of the frequency",
    needs="inertia", span=6.0, moving=True, steps=(1 / 24, 1 / 48, 1 / 96, 1 / 192),
    exact=lambda: {"ω": float(chain().frequencies[0]) * math.sqrt(G / LENGTH)},
    # a strand that bends freely, let go off the vertical in air that does not slow it
    case=lambda n: Case(preset(0.0, 1, n), groom([[math.sin(LET_GO), -math.cos(LET_GO), 0]], [LENGTH])),
    measure=measure_swing,
)  # fmt: skip
