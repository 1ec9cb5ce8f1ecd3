"""Strands of a file as chains of equal segments, which solvers take."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from hypothesis import given, settings
from hypothesis import strategies as st

from strandcli.groom_file.guides import chains

Points = npt.NDArray[np.float32]


@st.composite
def strands(draw: st.DrawFn) -> Points:
    """Straight, nearly straight, bent, curled and rough ones; some turn back, have points twice, or lie far out."""
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    count = draw(st.integers(2, 200))
    t = np.linspace(0, 1, count) if draw(st.booleans()) else np.sort(rng.random(count))
    along = rng.normal(size=3)
    points = t[:, None] * along
    kind = draw(st.sampled_from(("straight", "nearly", "bent", "curled", "rough", "back")))
    size, turns = {"straight": (0.0, 0), "nearly": (1e-4, 1), "bent": (0.5, 0.4)}.get(
        kind, (0.2, draw(st.floats(1, 40)))
    )
    wave = np.stack([np.cos(2 * np.pi * turns * t), np.sin(2 * np.pi * turns * t), 0 * t], 1)
    points += size * wave
    if kind == "rough":
        points += 0.1 * rng.normal(size=points.shape)
    if kind == "back":
        points = np.outer(np.abs(t - 0.5), along)
    if draw(st.booleans()):
        points = np.repeat(points, rng.integers(1, 4, count), axis=0)[:200]
    far = draw(st.sampled_from((0.0, 1.0, 100.0))) * rng.normal(size=3)
    return (draw(st.sampled_from((1e-3, 1.0, 1e3))) * (points + far)).astype(np.float32)


@settings(max_examples=40, deadline=None)
@given(strands(), st.integers(3, 40))
def test_chains_are_as_long_as_their_strands_and_end_at_their_tips(points: Points, particles: int) -> None:
    wide = points.astype(np.float64)
    whole = np.linalg.norm(np.diff(wide, axis=0), axis=1).sum()
    (joints,), (deviation,) = chains(points[None], particles)
    sizes = np.linalg.norm(np.diff(joints, axis=0), axis=1)
    scale = np.abs(wide).max()
    assert np.abs(sizes - whole / (particles - 1)).max() <= 1e-9 * whole + 1e-14 * scale
    assert (joints[0] == wide[0]).all()
    assert (joints[-1] == wide[-1]).all()
    assert deviation <= 2 * whole / (particles - 1) + 1e-9 * scale
