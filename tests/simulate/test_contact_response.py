"""The linearised response of strands to forces of contact, against steps with and without such a force."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from strandcli.constants import W
from strandcli.simulate.contact.kernels import contact_response
from strandcli.simulate.contact.kernels.contact_columns import ALPHA, NUMBERS
from strandcli.simulate.rod.kernels.arrays import PACK
from tests.simulate.test_strand_contact import solver_of

SEGMENTS, PARTICLE, PUSH = 32, 20, 0.1


@pytest.mark.parametrize(("fps", "young", "error"), [(96, "1.0e+8", 0.07), (24, "1.0e+8", 0.3), (24, "1.0e+10", 0.5)])
def test_curls_answer_a_force_as_their_response_says(fps: int, young: str, error: float) -> None:
    """All particles of a curl, soft and stiff ones, but for twist, which the response leaves out, and the more so the
    stiffer they are. Rest vectors that did not turn with edges would move stiff ones by a sixth of what steps do."""
    text = (
        f"rod: {{rest: shape, radius: 2.0e-4, young: {young}}}\n"
        f"time: {{fps: {fps}}}\nemitter: {{strands: 2, particles: {SEGMENTS + 1}, length: 0.3, curl_turns: 4, "
        "curl_angle: 50, shape: {kind: disc, radius: 0.3}}\nrules: [gravity, contact: {thickness: 0.0005}]"
    )
    solver = solver_of(text, double=True)
    solver.advance(3)
    contact = solver.contact
    assert contact is not None
    forces = contact._forces
    saved = {name: one.copy() for name, one in solver.state_arrays().items()}
    places = []
    for push in (0.0, PUSH):
        solver.restore(saved)

        def step(run: Any, dt: float, solver: Any, push: float = push) -> bool:
            solver.state.acceleration[...] = 0
            solver.state.acceleration.reshape(-1, SEGMENTS, 3, PACK)[0, PARTICLE, 0, 0] = push
            run()
            return True

        contact.step = step  # type: ignore[method-assign]
        solver._step(3 / fps, 1 / fps)
        places.append(forces.emitted(solver.state.positions[:, 1:], W)[0, 1:, 0])
    numbers, response = np.zeros((1, NUMBERS)), np.empty((1, 2, SEGMENTS, 3, 3))
    numbers[0, ALPHA] = 1
    method, both = forces._method(1 / fps, solver), np.arange(2)
    contact_response.respond(
        np.array([[0, PARTICLE, 1, PARTICLE]]), numbers, forces._factors(both, method, solver), both,
        forces.lengths / method.reach, response, np.empty((contact_response.BLOCK * SEGMENTS, 3)),
    )  # fmt: skip
    moved = places[1] - places[0]
    wanted = response[0, 0, :, 0, 0] * PUSH * forces.lengths[0] * float(solver.mass[PARTICLE]) / fps**2
    assert np.linalg.norm(wanted - moved) < error * np.linalg.norm(moved)
