"""Small oscillations of recorded runs: each mode's frequency and decay, against the exact ones."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from .base import Track
from .exact.modes import Modes
from .exact.quadrature import Array

COUNT = 3
"""Modes that are compared."""
STEPS: Mapping[str, tuple[float, ...]] = {
    "rod": (1 / 60, 1 / 120, 1 / 240, 1 / 480),
    "foil": (1 / 480, 1 / 960, 1 / 1920, 1 / 3840),
}
"""Steps in seconds to try, by solver: a swing asks for some dozens, and the foil for small ones."""

Swing = tuple[float, float]
"""An angular frequency ω and a decay rate λ, both 1/s."""

DECAYS = (0.0, 0.01, 0.03, 0.1, 0.3)
"""Decay rates over the frequency, from which a fit may start."""


def oscillation(times: Array, values: Array, guess: float, others: Sequence[Swing] = ()) -> Swing | None:
    """The swing of a + e^{−λ t} (b cos ω t + c sin ω t), fitted to values (T,) at times (T,) by least squares; a, b and
    c are eliminated (Golub & Pereyra 1973). ``guess`` is about ω; ``others`` are swings that are in the values as well.
    None where the values hold no such oscillation: fewer than 8 of them, no movement, or one over before it swings."""
    if len(times) < 8 or not np.isfinite(values).all() or np.ptp(values) == 0:
        return None
    t = times - times[0]

    def pair(omega: float, decay: float) -> list[Array]:
        size = np.exp(-np.clip(decay * t, -50, 50))
        return [size * np.cos(omega * t), size * np.sin(omega * t)]

    basis = np.stack([np.ones_like(t), *[wave for other in others for wave in pair(*other)]], 1)
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


def errors(modes: Modes, unit: float, track: Track, axis: int) -> dict[str, float | None]:
    """Relative errors of the frequencies of modes, in 1/s by their ``unit``, in the first strand's places along one
    axis of space; ``loss``, the share of the first mode's amplitude that a cycle loses; and ``swing``, which holds both
    errors of the first mode: that of its complex frequency ω + i λ, of which λ should be 0. A discrete strand's modes
    are not quite the exact ones, so that slower modes show in the share of each, and are taken out of it."""
    times, swings = track.times, modes.shares(track.positions[:, 0, :, axis])
    found: list[Swing] = []
    out: dict[str, float | None] = {"swing": None}
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
