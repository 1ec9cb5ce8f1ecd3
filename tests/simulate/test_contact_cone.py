"""The forces that one solid and two may give a particle (`kernels.contact_cone`)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from numba import njit
from numpy.typing import NDArray

from strandcli.blocks import aligned
from strandcli.constants import VECTOR
from strandcli.simd import load, load3, store3, vector_pointer_at
from strandcli.simulate.kernels import contact_cone

LANES = VECTOR // 8
HELD, ONE, WANTED, OTHER, THERE, FRICTION, FORCE, GROOVE = 0, 3, 6, 9, 12, 15, 16, 19
ROWS = 22
angles = st.floats(-3.0, 3.0)
lengths = st.floats(-1.0, 1.0)


@njit(error_model="numpy")
def give(address):
    """Store what two solids give beside what `by_two` takes of them."""
    s = vector_pointer_at(np.float64, address)
    given = contact_cone.by_two(
        load3(s, HELD, 1), load3(s, ONE, 1), load3(s, WANTED, 1), load3(s, OTHER, 1), load3(s, THERE, 1),
        load(s, FRICTION),
    )  # fmt: skip
    store3(s, FORCE, 1, given.force[0], given.force[1], given.force[2])
    store3(s, GROOVE, 1, given.groove[0], given.groove[1], given.groove[2])


class Case(NamedTuple):
    """A particle between two solids, with unit ``normals`` (2, 3), that would be ``depths`` (2,) deep without forces
    and ``slides`` (2, 3) along their surfaces."""

    normals: NDArray[np.float64]
    depths: NDArray[np.float64]
    slides: NDArray[np.float64]
    held: NDArray[np.float64]


@st.composite
def cases(draw: st.DrawFn) -> Case:
    """Solids with at least 12 degrees between their normals, and at most 168."""
    seed = draw(st.integers(0, 2**32 - 1))
    random = np.random.default_rng(seed)
    normals = random.normal(size=(2, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    assume(abs(normals[0] @ normals[1]) < 0.978)
    slides = random.normal(size=(2, 3))
    slides -= np.sum(slides * normals, axis=1)[:, None] * normals
    held = draw(st.floats(0, 1)) * normals[0] + draw(st.floats(0, 1)) * normals[1]
    return Case(normals, np.array([draw(lengths), draw(lengths)]), draw(st.sampled_from([0.0, 0.3])) * slides, held)


def given_by(case: Case, friction: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The displacement by the force, and the groove."""
    pile = aligned((ROWS, LANES), np.float64)
    pile[...] = 0
    deep = case.depths - case.normals @ case.held
    wanted = deep[:, None] * case.normals - case.slides
    for place, vector in (
        (HELD, case.held), (ONE, case.normals[0]), (WANTED, wanted[0]), (OTHER, case.normals[1]), (THERE, wanted[1]),
    ):  # fmt: skip
        pile[place : place + 3] = vector[:, None]
    pile[FRICTION] = friction
    give(pile.ctypes.data)
    assert (pile == pile[:, :1]).all()
    return pile[FORCE : FORCE + 3, 0].copy(), pile[GROOVE : GROOVE + 3, 0].copy()


def way_out(case: Case) -> NDArray[np.float64]:
    """The shortest way out of both solids: of all that end at the surfaces of some of them, outside of the others."""
    ways = [np.zeros(3)]
    for rows in ([0], [1], [0, 1]):
        normals, depths = case.normals[rows], case.depths[rows]
        ways.append(normals.T @ np.linalg.solve(normals @ normals.T, depths))
    outside = [way for way in ways if (case.normals @ way >= case.depths - 1e-12).all()]
    return min(outside, key=lambda way: float(way @ way))


@given(cases())
def test_without_friction_a_particle_goes_the_shortest_way_out_of_both(case: Case) -> None:
    force, _ = given_by(case, 0.0)
    np.testing.assert_allclose(force, way_out(case), atol=1e-9)


@given(cases(), st.floats(0.05, 1.5))
def test_forces_lead_out_of_both_and_keep_to_their_cones(case: Case, friction: float) -> None:
    force, groove = given_by(case, friction)
    left = case.depths - case.normals @ force
    assert left.max() < 1e-9
    if groove.any():
        shares = np.linalg.solve(np.array([*case.normals, groove]).T, force)
        assert shares[:2].min() > -1e-12
        assert abs(shares[2]) <= friction * shares[:2].sum() + 1e-12
        assert np.abs(case.normals @ groove).max() < 1e-9
    else:
        along = [np.linalg.norm(force - force @ n * n) <= friction * (force @ n) + 1e-9 for n in case.normals]
        assert any(along)
