"""Strands that interact and begin inside each other."""

from __future__ import annotations

import numpy as np
import pytest

from strand_kit import scene_of
from strandcli.groom.emit import emit
from strandcli.simulate.rod import RodSolver


@pytest.mark.parametrize("steps", [1, 10])
@pytest.mark.parametrize("curled", ["", ", curl_turns: 6, curl_angle: 50"])
def test_strands_that_begin_inside_each_other_are_led_apart_without_a_jump(curled: str, steps: int) -> None:
    """Thirty times too dense at the start; coils cut steps into up to twenty. In a frame none moves by four cells,
    however many steps it has; half a cell more in each of them would be up to seven."""
    rest = "rest: shape, " if curled else "rest: straight, "
    scene = scene_of(
        f"solver: rod\nrod: {{{rest}radius: 1.0e-4, drag: 5}}\ntime: {{fps: {24 * steps}}}\n"
        "emitter: {shape: {kind: disc, radius: 0.001}, strands: 300, particles: 12, length: 0.2, jitter: 2, "
        f"rotation: [180, 0, 0]{curled}}}\nrules: [gravity, interaction: {{cell: 0.02, density: 1.0e+4}}]"
    )
    solver = RodSolver(scene, emit(scene.emitter, scene.seed))
    furthest, before = 0.0, solver.particles()
    for frame in range(6):
        for step in range(steps):
            solver.step((frame * steps + step + 1) / (24 * steps), 1 / (24 * steps))
        after = solver.particles()
        furthest, before = max(furthest, float(np.linalg.norm(after - before, axis=2).max())), after
    assert furthest < 4 * 0.02
    assert np.std(after[:, -1, 0]) > 0.002  # and they are led apart
