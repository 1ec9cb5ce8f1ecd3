"""Contact between strands: closed forms, Newton's third law, an independent search for crossings, and extremes."""

from __future__ import annotations

from typing import Any

import numba
import numpy as np
import pytest
from numpy.typing import NDArray

from crossing_kit import crossings, strands
from rod_kit import rod_of
from strandcli.errors import UsageError
from strandcli.groom.record import Groom
from strandcli.scene import SceneError
from strandcli.simulate.contact.kernels import contact_response
from strandcli.simulate.contact.kernels.contact_pairs import Nearby
from strandcli.simulate.rod.kernels.arrays import PACK

Floats = NDArray[np.float64]
CROSS = "rod: {{rest: straight, radius: 1.0e-3, young: {young}, drag: 0}}\ntime: {{fps: 24}}\n"
RULE = "emitter: {{strands: 2, particles: 11, length: 1}}\nrules: [gravity, contact: {{thickness: {d}, friction: 0.5}}]"


def laid_pair(n: int, turns: float, radius: float, length: float) -> Groom:
    """Two strands about each other, which hang down a ``length``."""
    angles = 2 * np.pi * turns * np.arange(n + 1) / n
    down = -length * np.arange(n + 1) / n
    points = [np.stack([s * radius * np.cos(angles), down, s * radius * np.sin(angles)], 1) for s in (1, -1)]
    ways = np.stack([np.diff(p, axis=0) for p in points])
    lengths = np.linalg.norm(ways, axis=2).sum(1)
    ways /= np.linalg.norm(ways, axis=2)[:, :, None]
    return Groom(
        np.array([p[0] for p in points], np.float32), ways[:, 0].astype(np.float32), lengths.astype(np.float32),
        np.zeros(2, np.float32), edges=ways,
    )  # fmt: skip


@pytest.mark.parametrize(("speed", "young"), [(1, "5.0e+9"), (10, "5.0e+5"), (1000, "5.0e+9")])
def test_strands_shot_at_each_other_do_not_pass(speed: float, young: str, steps: list[tuple[Floats, Floats]]) -> None:
    """However far they would go in a step: up to forty times their length, or ten thousand thicknesses."""
    groom = strands([[-0.5, 0, 0], [0.02, 0.05, -0.5]], [[1, 0, 0], [0.02, 0, 1]], [1, 1])
    solver = rod_of(CROSS.format(young=young) + RULE.format(d=0.004), groom)
    for axis, sign in ((0, 1), (1, -1)):
        solver.state.velocity.reshape(1, 10, 3, PACK)[0, :, axis, 0] = sign * speed
    solver.advance(7)
    assert sum(crossings(*one) for one in steps) == 0
    assert solver.errors(7)["nonfinite"] == 0


def test_one_strand_rests_on_another() -> None:
    """At the distance asked for, and still."""
    groom = strands([[-0.1, -0.02, 0], [0, 0.05, -0.5]], [[1, 0, 0], [0, 0, 1]], [0.2, 1])
    solver = rod_of(CROSS.format(young="5.0e+9").replace("drag: 0", "drag: 20") + RULE.format(d=0.01), groom)
    solver.advance(60)
    then = solver.particles()
    solver.advance(70)
    now = solver.particles()
    error = solver.errors(70)
    assert error["strand_penetration_max"] < 3e-5  # type: ignore[operator]
    assert np.abs(now - then).max() < 1e-3
    nearest = np.linalg.norm(fine(now[0])[:, None] - fine(now[1])[None], axis=2).min()
    assert nearest == pytest.approx(0.01, abs=1e-4)


def fine(strand: NDArray[Any]) -> Floats:
    """Many points of a strand."""
    at = np.linspace(0, len(strand) - 1, 2001)
    return np.stack([np.interp(at, np.arange(len(strand)), strand[:, c]) for c in range(3)], 1)


def test_contact_keeps_momentum() -> None:
    """What one strand gets the other loses: forces times masses add up to nothing, where lengths differ too."""
    groom = strands([[-0.1, -0.02, 0], [0, 0.05, -0.5]], [[1, 0, 0], [0, 0, 1]], [0.2, 1])
    solver = rod_of(CROSS.format(young="5.0e+9") + RULE.format(d=0.01), groom)
    seen = 0
    for frame in range(2, 14):
        solver.advance(frame)
        pushes = solver.state.acceleration.reshape(1, 10, 3, PACK)[0, :, :, :2].astype(float)
        lengths = groom.lengths / 10
        sums = np.einsum("jcs,j,s->cs", pushes, solver.mass.astype(float), lengths)
        if np.abs(sums).max() > 0:
            seen += 1
            assert np.abs(sums.sum(1)).max() < 2e-6 * np.abs(sums).max()
    assert seen > 3


def test_a_twisted_pair_keeps_its_turns(steps: list[tuple[Floats, Floats]]) -> None:
    """Two strands about each other, pulled straight by their weight: without contact they come out of it at once. With
    it the tips, which nothing holds, come apart one turn after the other; the upper half stays as it is."""
    n, turns = 24, 2.0
    half, groom = n // 2, laid_pair(n, turns, 0.012, 1.0)
    text = (
        "rod: {rest: straight, radius: 1.0e-3, young: 1.0e+6, drag: 2}\ntime: {fps: 60}\n"
        "emitter: {strands: 2, particles: 25, length: 1}\nrules: [gravity: {acceleration: [0, -30, 0]}%s]"
    )
    left = []
    for rule in (", contact: {thickness: 0.01, friction: 0.6}", ""):
        solver = rod_of(text % rule, groom)
        solver.advance(16)
        way = solver.particles()[1].astype(float) - solver.particles()[0]
        around = np.unwrap(np.arctan2(way[: half + 1, 2], way[: half + 1, 0]))
        left.append(abs(around[-1] - around[0]) / (2 * np.pi))
        if rule:
            assert sum(crossings(*one) for one in steps) == 0
            assert solver.errors(16)["strand_penetration_max"] < 4e-3  # type: ignore[operator]
    assert left[0] > 0.85 * turns * half / n
    assert left[1] < 0.5 * left[0]


@pytest.mark.parametrize("curled", [False, True])
def test_the_response_is_how_the_step_answers_a_force(curled: bool) -> None:
    """Against a dense solution of the same equations."""
    rng = np.random.default_rng(0)
    n = 6
    edges = rng.normal(size=(1, n, 3))
    edges /= np.linalg.norm(edges, axis=2)[:, :, None]
    mass, joint, stiffness = rng.uniform(0.5, 2, n), rng.uniform(0.5, 2, n), 3.0
    tension, normals = rng.uniform(-1, 4, (1, n)), np.zeros((1, n, 3))
    bands = np.empty((1, 4 * n, contact_response.BAND))
    contact_response.factorise(
        np.zeros(1, np.int64), edges, (np.array([stiffness]), tension, normals), mass, joint, curled, bands,
        np.empty((3, 3, 3)),
    )  # fmt: skip
    pairs, numbers = np.array([[0, 3, 0, 0]]), np.zeros((1, 7))
    numbers[0, 0] = 0.3
    out, places, lengths = np.empty((1, 2, n, 3, 3)), np.zeros(1, np.int64), np.array([0.5])
    contact_response.respond(pairs, numbers, bands, places, lengths, out, np.empty((4 * n, 3)))
    d = np.eye(n) - np.eye(n, k=-1)
    bend = d @ d
    h = np.kron(np.diag(mass) + d.T @ np.diag(np.maximum(tension[0], 0)) @ d, np.eye(3))
    for j in range(n):
        part = np.kron(bend[j], np.eye(3))
        if curled and j > 0:  # rest vectors turn as the edge before them
            e, f = edges[0, j - 1], edges[0, j]
            turned = np.outer(e, f) + (1 - e @ f) * np.eye(3)
            part += turned @ np.kron(d[j - 1], np.eye(3))
        h += stiffness * joint[j] * part.T @ part
    jacobian = np.einsum("ji,jc->jic", d, edges[0]).reshape(n, 3 * n)
    matrix = np.block([[h, jacobian.T], [jacobian, np.zeros((n, n))]])
    force, end = np.zeros((4 * n, 3)), 9
    force[end : end + 3], force[end - 3 : end] = 0.3 / 0.5 * np.eye(3), 0.7 / 0.5 * np.eye(3)
    wanted = np.linalg.solve(matrix, force)[: 3 * n].reshape(n, 3, 3)
    np.testing.assert_allclose(out[0, 0], wanted, atol=1e-10)


TUFT = (
    "rod: {rest: straight, radius: 2.0e-4, young: 1.0e+8}\n"
    "emitter: {shape: {kind: disc, radius: 0.01}, strands: 24, particles: 9, length: 0.1, jitter: 15, "
    "keys: [{time: 0}, {time: 0.5, position: [0.05, 0, 0]}]}\n"
    "rules: [emitter_motion, gravity, contact: {thickness: 0.001}]"
)


def test_any_number_of_threads_and_a_restart_give_the_same_bits() -> None:
    found = []
    for threads in {1, min(2, numba.config.NUMBA_NUM_THREADS)}:
        numba.set_num_threads(threads)
        solver = rod_of(TUFT)
        solver.advance(4)
        saved = {name: one.copy() for name, one in solver.state_arrays().items()}
        solver.advance(6)
        found.append(solver.particles())
        again = rod_of(TUFT)
        again.restore(saved)
        again.advance(6)
        found.append(again.particles())
    for one in found:
        np.testing.assert_array_equal(one, found[0])


@pytest.mark.parametrize(
    ("rule", "message"),
    [
        ("thickness: 5", "more than the groom"),
        ("thickness: .nan", "finite"),
        ("thickness: -1", "must be a number above 0"),
        ("friction: -0.1", "of at least 0"),
        ("friction: 11", "must be"),
        ("iterations: 0", "must be"),
    ],
)
def test_bad_input_is_refused_by_name(rule: str, message: str) -> None:
    with pytest.raises((UsageError, SceneError), match="contact") as caught:
        rod_of(f"emitter: {{strands: 2, particles: 3, length: 0.1}}\nrules: [contact: {{{rule}}}]")
    assert message in str(caught.value)


def test_friction_over_one_is_allowed_and_no_contact_costs_nothing() -> None:
    one = rod_of("emitter: {strands: 2, particles: 3, length: 0.1}\nrules: [gravity, contact: {friction: 1.5}]")
    assert one.contact is not None
    other = rod_of("emitter: {strands: 2, particles: 3, length: 0.1}\nrules: [gravity]")
    assert other.contact is None
    assert len(other.state.acceleration) == 1
    assert "strand_penetration_max" not in other.errors(1)


@pytest.mark.parametrize("thickness", [0.0002, 0.001, 0.005])
@pytest.mark.parametrize("speed", [3, 8, 200])
def test_thin_strands_that_fall_across_each_other_do_not_pass(
    speed: float, thickness: float, steps: list[tuple[Floats, Floats]]
) -> None:
    """One turns about its root onto the other, and slides along it, at three angles."""
    for angle in np.radians([90, 45, 10]):
        x, z = np.cos(angle), np.sin(angle)
        groom = strands([[-0.5, 0, 0], [-0.5 * x, 0.3, -0.5 * z]], [[1, 0, 0], [x, 0, z]], [1, 1])
        text = (
            "rod: {rest: straight, radius: 1.0e-3, young: 1.0e+9, drag: 0, damping: 0}\n"
            f"time: {{fps: 24}}\nemitter: {{strands: 2, particles: 11, length: 1}}\n"
            f"rules: [gravity: {{acceleration: [0, 0, 0]}}, contact: {{thickness: {thickness}}}]\n"
        )
        solver = rod_of(text, groom)
        for one in (solver.state.velocity, solver.state.before, solver.state.ahead):
            rows = one.reshape(1, -1, 3, PACK)
            rows[0, :, 1, 1] = -speed * np.linspace(0, 1, rows.shape[1])
        solver.advance(14 + int(30 / speed))
    assert sum(crossings(*one) for one in steps) == 0


def test_pairs_are_those_whose_boxes_meet() -> None:
    """Against all pairs, of segments that differ a hundredfold in size."""
    rng = np.random.default_rng(1)
    start = rng.normal(size=(30, 1, 3)) + np.cumsum(
        rng.normal(size=(30, 8, 3)) * np.exp(rng.normal(size=(30, 1, 1)) - 2), 1
    )
    end = start + 0.1 * rng.normal(size=start.shape)
    found = Nearby(7, 1).find(start, end, 0.1)
    ends = np.stack([start[:, :-1], start[:, 1:], end[:, :-1], end[:, 1:]])
    low, high = ends.min(0).reshape(-1, 3) - 0.05, ends.max(0).reshape(-1, 3) + 0.05
    meet = ((low[:, None] <= high[None]) & (low[None] <= high[:, None])).all(2)
    i, j = np.nonzero(np.triu(meet, 1))
    keep = (i // 7 != j // 7) | (abs(i - j) > 1)
    wanted = np.stack([i // 7, i % 7, j // 7, j % 7], 1)[keep]
    np.testing.assert_array_equal(found, wanted)
    assert len(found) > 300
