"""Bounds on the time of a frame's stages by the roofline model (Williams, Waterman & Patterson 2009).

A stage cannot take less than moving what it reads and writes, nor than the operations that it cannot do without, at the
rates that the machine is measured to have in the same sitting, on the same threads.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from .kernels import roofline as kernels

Counts = Mapping[str, int]
BYTES, OPERATIONS = 2**26, 2**28
"""Bytes that are moved and operations that are made in a run that is timed, about."""
RUNS = 5
"""Runs, the least of which counts, after one that does not."""


class Bound(NamedTuple):
    """What an element of a stage costs at the least."""

    stage: str
    element: str
    count: Callable[[Counts], int]
    """The number of elements in a frame, from its counts."""
    memory: Callable[[Counts], float]
    """Bytes that are read and written for an element."""
    operations: Callable[[Counts], float]
    """Additions, multiplications, divisions, comparisons and roots for an element."""


def _of(name: str) -> Callable[[Counts], int]:
    return lambda counts: counts.get(name, 0)


def _is(number: float) -> Callable[[Counts], float]:
    return lambda counts: number


def _a_particle(counts: Counts) -> float:
    """Bytes of a vertex: its place and its place on the screen, and its share of the particle that it comes from."""
    return 24 + 12 * counts["particles"] / max(counts["vertices"], 1)


BOUNDS: dict[str, Bound] = {
    "move": Bound("simulate", "particle and step", _of("particle_steps"), _is(36), _is(24)),
    "children": Bound("children", "child's particle", _of("child_particles"),
                      lambda c: 12 + 24 * c["children"] / max(c["child_particles"], 1), _is(15)),
    "curves": Bound("curves", "vertex", _of("vertices"), _a_particle, _is(43)),
    "splats": Bound("shadow", "splat", _of("splats"), _is(32), _is(5)),
    "texels": Bound("shadow", "texel on a line", _of("map_texels"), _is(24), _is(2)),
    "lines": Bound("shadow", "vertex in a map", _of("strand_vertices_in_maps"), _is(24), _is(21)),
    "fragments": Bound("raster", "fragment", _of("fragments_found"), _is(24), _is(2)),
    "keys": Bound("raster", "sample on a line", _of("line_samples"), _is(28), _is(1)),
    "vertices": Bound("shade", "vertex and light", lambda c: c["lit_vertices"] * c["lights"],
                      lambda c: 32 + 32 * bool(c["lights_with_maps"]) + 36 / max(c["lights"], 1),
                      lambda c: 30 + 60 * bool(c["lights_with_maps"])),
    "pixels": Bound("shade", "solid's sample and light", lambda c: c["solid_samples"] * c["lights"],
                    lambda c: 32 * bool(c["lights_with_maps"]) + 24 / max(c["lights"], 1),
                    lambda c: 2 + 60 * bool(c["lights_with_maps"])),
    "film": Bound("film", "sample", _of("samples"), lambda c: 12 + 6 / c["samples_a_side"] ** 2, _is(6)),
    "blend": Bound("film", "fragment seen", _of("fragments_blended"), _is(36), _is(14)),
    "colour": Bound("film", "strand's sample", _of("strand_samples"), _is(44), _is(9)),
    "deflate": Bound("write", "byte", _of("bytes"), _is(1), _is(1)),
}  # fmt: skip
"""By name. Those of one stage add up, and the first that a frame has tells what the stage's element is."""


def rates(clock: Callable[[], float]) -> tuple[float, float]:
    """Seconds a byte and seconds an operation, of this machine on the threads that are set."""
    source, target = np.ones(BYTES // 8, np.float32), np.empty(BYTES // 8, np.float32)
    numbers = np.ones((OPERATIONS // (2 * 64 * kernels.ROUNDS), 64), np.float32)
    return (
        _least(lambda: kernels.copy(source, target), clock) / (8 * len(source)),
        _least(lambda: kernels.multiply(numbers), clock) / (2 * kernels.ROUNDS * numbers.size),
    )


def _least(run: Callable[[], object], clock: Callable[[], float]) -> float:
    """Seconds of the fastest run."""
    times = []
    for _ in range(RUNS + 1):
        began = clock()
        run()
        times.append(clock() - began)
    return min(times[1:])


def bounds_of(stage: str, counts: Counts, rates: tuple[float, float]) -> list[dict[str, Any]]:
    """The bounds of a stage that a frame with these counts has: what each works on, and nanoseconds for each."""
    found = []
    for name, bound in BOUNDS.items():
        if bound.stage == stage and bound.count(counts):
            size, operations = bound.memory(counts), bound.operations(counts)
            found.append({
                "loop": name, "element": bound.element, "count": bound.count(counts), "bytes": size,
                "operations": operations, "element_ns": 1e9 * max(size * rates[0], operations * rates[1]),
            })  # fmt: skip
    return found
