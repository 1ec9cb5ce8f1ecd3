"""Running solvers: the strands that a study takes, steps that are timed, and positions that can be compared."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...errors import UsageError
from ...groom.emit import emit
from ...groom.record import Groom
from ...scene.model import Scene

T = TypeVar("T")
Array = NDArray[np.float64]


def guides_of(scene: Scene, most: int | None = None) -> Groom:
    """What a scene simulates, at most the first so many of the strands that it grows."""
    if scene.emitter.groom is None:
        return emit(scene.emitter, scene.seed, most)
    from ...groom_file import guided

    return guided(scene).guides


def with_fewer_guides(scene: Scene, name: str, most: int) -> Scene:
    """A scene that simulates at most so many of the strands of its file, where it has one. Raises `UsageError` where
    nothing moves these."""
    given = scene.emitter.groom
    if given is None:
        return scene
    if not scene.guided:
        raise UsageError(f"{name}: nothing moves the strands of its file; list a rule, or study an --axis of pictures")
    if given.guides <= most:
        return scene
    from ...groom_file import completed

    emitter = replace(scene.emitter, groom=replace(given, guides=most), followers=None)
    return completed(replace(scene, emitter=emitter))


def warm(make: Callable[[], Any], dt: float) -> Any:
    """A solver. What has to be compiled is compiled by two steps of one that is thrown away."""
    solver = make()
    for i in range(2):
        solver.step((i + 1) * dt, dt)
    return make()


def least(run: Callable[[], tuple[T, float]], quick: float = 0.2, times: int = 3) -> tuple[T, float]:
    """What a run gives, with the least of its seconds: one that is quick is repeated, to be timed fairly."""
    found, seconds = run()
    while seconds < quick and times > 1:
        found, again = run()
        seconds = min(seconds, again)
        times -= 1
    return found, seconds


def follow(make: Callable[[], Any], dt: float, span: float, moving: bool) -> tuple[Array, Array, float]:
    """Run a solver from rest for a span of seconds in steps of ``dt``; returns times (T,), positions
    (T, strands, particles, 3), of every step where it is ``moving`` and else of the first and the last, and the seconds
    that the steps took, compiling not counted."""
    solver = warm(make, dt)
    steps, seconds = max(1, round(span / dt)), 0.0
    times, positions = [0.0], [solver.particles().astype(np.float64)]
    for i in range(steps):
        began = time.perf_counter()
        solver.step((i + 1) * dt, dt)
        seconds += time.perf_counter() - began
        if moving or i == steps - 1:
            times.append((i + 1) * dt)
            positions.append(solver.particles().astype(np.float64))
    return np.array(times), np.array(positions), seconds


def resample(strands: NDArray[np.floating], places: int) -> Array:
    """(..., particles, 3) -> (..., places, 3): points at even shares of each polyline's own length, both ends included.
    A strand of no length is repeated."""
    points = np.asarray(strands, np.float64)
    sizes = np.linalg.norm(np.diff(points, axis=-2), axis=-1)
    along = np.concatenate([np.zeros((*sizes.shape[:-1], 1)), np.cumsum(sizes, -1)], -1)
    goals = along[..., -1:] * np.linspace(0, 1, places)
    after = (along[..., None, 1:-1] <= goals[..., None]).sum(-1)  # the segment that each goal lies on
    start = np.take_along_axis(along, after, -1)
    size = np.take_along_axis(sizes, after, -1)
    share = np.clip((goals - start) / np.where(size > 0, size, 1.0), 0.0, 1.0)
    a = np.take_along_axis(points, after[..., None], -2)
    b = np.take_along_axis(points, after[..., None] + 1, -2)
    return np.asarray(a + share[..., None] * (b - a))


def apart(a: Array, b: Array, lengths: NDArray[np.floating]) -> dict[str, float]:
    """How far two sets of strands (T, strands, places, 3) are apart, as shares of each strand's length (strands,) in
    metres: ``median`` and ``p95`` over strands of each one's root mean square over places and times; ``rms`` over all,
    and the greatest distance of all, ``max``.

    Where strands meet solids, the least of differences decides to which side some fall; such motion has no limit. They
    show in p95 and max.
    """
    away = np.linalg.norm(a - b, axis=-1) / np.asarray(lengths, np.float64)[:, None]
    each = np.sqrt(np.mean(away**2, axis=(0, 2)))
    return {
        "median": float(np.median(each)),
        "p95": float(np.percentile(each, 95)),
        "rms": float(np.sqrt(np.mean(away**2))),
        "max": float(away.max()),
    }
