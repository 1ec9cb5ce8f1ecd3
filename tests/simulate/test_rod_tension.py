"""An iteration of Newton's against dense algebra: elimination, and lengths and contacts by the Kalman filter."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from scratch_kit import LANES, Floats, Rows, scratch
from strandcli.jit import function
from strandcli.simd import load
from strandcli.simulate.contact.kernels import law
from strandcli.simulate.rod.kernels import newton, tension
from strandcli.simulate.rod.kernels.arrays import Material
from strandcli.simulate.rod.kernels.newton import MASS_SHARE

STIFFNESS = 0.7


@function
def solve(rows, n, mass, material):
    """Change displacements and edges by H⁻¹ ρ."""
    s = scratch(rows, n)
    stiffness = load(s.pivot, 0) * 0.0 + STIFFNESS
    newton.factorise(s, n, material, stiffness, False, False, False, stiffness * 0.0)
    newton.apply_change(s, n)


@function
def iterate(rows, n, mass, material, touching, whole):
    """The same after τ and forces of contact have changed as the filter finds."""
    s = scratch(rows, n)
    stiffness = load(s.pivot, 0) * 0.0 + STIFFNESS
    newton.factorise(s, n, material, stiffness, False, touching, whole, stiffness * 0.0)
    tension.filter_forward(s, n, mass, True, touching, whole)
    newton.update_loads(s, n, material, stiffness, True, touching, whole)
    newton.apply_change(s, n)


class Strands:
    """Scratch of strands with random states; friction, contacts and places on segments by choice."""

    def __init__(self, n: int, touching: bool = False, whole: bool = False) -> None:
        rng = np.random.default_rng(n)
        self.n, self.rows, self.whole = n, Rows(n), whole
        self.mass, self.joint = rng.uniform(0.5, 2.0, (2, n))
        rows = self.rows
        for name in ("inertial", "rest", "firm", "free"):
            getattr(rows, name)[...] = 0.1 * rng.normal(size=getattr(rows, name).shape)
        rows.edge[...] = rng.normal(size=rows.edge.shape)
        rows.edge[...] *= rng.uniform(0.9, 1.1, (n, 1, LANES)) / np.linalg.norm(rows.edge, axis=1, keepdims=True)
        rows.before("edge")[:] = np.eye(3)[:1].T
        rows.tension[...] = rng.uniform(0.0, 3.0, rows.tension.shape)
        rows.share[...] = rng.uniform(0.1, 1.0, rows.share.shape) if whole else 1.0
        if touching:
            rows.active[...] = rng.uniform(size=rows.active.shape) < 0.6
            axes = np.linalg.qr(rng.normal(size=(n, LANES, 3, 3)))[0]
            rows.normal[...], rows.across[...] = axes[..., 0].transpose(0, 2, 1), axes[..., 1].transpose(0, 2, 1)
            rows.force[...] = rows.active * rng.normal(size=rows.force.shape)
            rows.wanted[...] = 0.1 * rng.normal(size=rows.wanted.shape)
            # a place that sticks beside another one, or at the first edge, has more to obey than ways to move
            rows.compliance[...] = np.where(
                np.arange(n)[:, None, None] % 3 == 2, 0.0, rng.uniform(0.1, 1.0, (n, 2, LANES))
            )
        self.material = Material(self.mass, self.mass, self.mass, self.joint, self.mass)

    def tangents(self) -> Floats:
        """(3, n, 3, LANES) the normals and both tangents."""
        n, one = self.rows.normal, self.rows.across
        return np.array([n, one, np.cross(n, one, axis=1)])

    def matrices(self, lane: int) -> tuple[Floats, Floats]:
        """H, and D, which makes changes of edges of displacements."""
        d = np.eye(self.n) - np.eye(self.n, k=-1)
        bend = d @ d
        h = np.diag(self.mass) + d.T @ np.diag(self.rows.tension[:, 0, lane]) @ d
        return h + bend.T @ np.diag(STIFFNESS * self.joint) @ bend, d

    def residual(self, lane: int) -> Floats:
        """(n, 3) ρ."""
        rows = self.rows
        edge = rows.edge[..., lane]
        before = np.concatenate([rows.before("edge")[None, :, lane], edge[:-1]])
        bend = STIFFNESS * self.joint[:, None] * (edge - before - rows.rest[..., lane])
        f = rows.tension[..., lane] * edge - rows.firm[:, :3, lane] + bend - np.append(bend[1:], np.zeros((1, 3)), 0)
        return self.mass[:, None] * rows.inertial[..., lane] - f + np.append(f[1:], np.zeros((1, 3)), 0)


@pytest.mark.parametrize("n", [1, 2, 9, 40])
def test_elimination_solves_the_dense_system(n: int) -> None:
    strands = Strands(n)
    edge, inertial = strands.rows.edge.copy(), strands.rows.inertial.copy()
    wanted = []
    for lane in range(LANES):
        h, d = strands.matrices(lane)
        y = np.linalg.solve(h, strands.residual(lane))
        wanted.append((y, d @ y))
    solve(strands.rows.all, n, strands.mass, strands.material)
    for lane, (y, z) in enumerate(wanted):
        np.testing.assert_allclose(inertial[..., lane] - strands.rows.inertial[..., lane], y, atol=1e-10)
        np.testing.assert_allclose(strands.rows.edge[..., lane] - edge[..., lane], z, atol=1e-10)


def test_compression_is_bounded_in_the_matrix_alone() -> None:
    """H of lanes where it would be indefinite takes no τ below what masses resist; their residual keeps it."""
    n, lane = 9, 1
    strands = Strands(n)
    tension, inertial = strands.rows.tension, strands.rows.inertial.copy()
    tension[:, 0, lane] = np.linspace(-5.0, 1.0, n)
    residual = strands.residual(lane)
    given = tension.copy()
    tension[:, 0, lane] = np.maximum(
        given[:, 0, lane], -MASS_SHARE * np.minimum(strands.mass, np.roll(strands.mass, 1))
    )
    tension[0, 0, lane] = -MASS_SHARE * strands.mass[0]
    y = np.linalg.solve(strands.matrices(lane)[0], residual)
    tension[...] = given
    solve(strands.rows.all, n, strands.mass, strands.material)
    np.testing.assert_allclose(inertial[..., lane] - strands.rows.inertial[..., lane], y, atol=1e-10)


@pytest.mark.parametrize("whole", [False, True], ids=["ends", "places"])
@pytest.mark.parametrize("touching", [False, True], ids=["free", "contact"])
@pytest.mark.parametrize("n", [1, 2, 9, 40])
def test_the_filter_finds_what_keeps_lengths_gaps_and_friction(n: int, touching: bool, whole: bool) -> None:
    """The changes of τ and of forces are those of the dense system: S δ = r of all that is observed."""
    strands = Strands(n, touching, whole)
    rows = strands.rows
    given = {name: getattr(rows, name).copy() for name in ("edge", "tension", "force", "inertial", "free")}
    wanted = [dense(strands, lane) for lane in range(LANES)]
    iterate(rows.all, n, strands.mass, strands.material, touching, whole)
    for lane, (tension_change, force_change, moved, z) in enumerate(wanted):
        found = {name: getattr(rows, name)[..., lane] - one[..., lane] for name, one in given.items()}
        np.testing.assert_allclose(found["tension"][:, 0], tension_change, atol=1e-8)
        np.testing.assert_allclose(found["force"], force_change, atol=1e-8)
        np.testing.assert_allclose(found["free"], moved, atol=1e-8)
        np.testing.assert_allclose(found["edge"], z, atol=1e-8)


def add_proximal(give: Floats, s: Floats, n: int, active: NDArray[np.intp]) -> None:
    """Add to the compliances of friction what holds it to the last force: a share of the trace of its mobility, given
    all that is observed nearer to the root and the place's normal."""
    for k, j in enumerate(active):
        normal = n + 3 * k
        tangents = [normal + 1, normal + 2]
        nearer = [*range(j), *range(n, normal + 1)]
        known = np.linalg.solve(s[np.ix_(nearer, nearer)] + np.diag(give[nearer]), s[np.ix_(nearer, tangents)])
        give[tangents] += law.PROXIMAL * np.trace(s[np.ix_(tangents, tangents)] - s[np.ix_(tangents, nearer)] @ known)


def dense(strands: Strands, lane: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Changes of τ (n,), of forces, of u* and of edges (n, 3) in a lane, by S⁻¹."""
    rows, n, mass = strands.rows, strands.n, strands.mass
    h, d = strands.matrices(lane)
    free = np.linalg.solve(h, strands.residual(lane))
    edge = rows.edge[..., lane]
    active = np.flatnonzero(rows.active[:, 0, lane])
    w = 1 - rows.share[:, 0, lane]
    place = np.eye(n) - w[:, None] * d  # what moves with the place of each segment
    tangents = strands.tangents()[..., lane]
    observed = [np.outer(d[j], edge[j]).ravel() for j in range(n)]
    observed += [np.outer(place[j], tangents[k, j]).ravel() for j in active for k in range(3)]
    a = np.array(observed)
    size = np.linalg.norm(edge, axis=1)
    missing = np.concatenate([size**2 * (size - 1), rows.wanted[active, :, lane].ravel()]) + a @ free.ravel()
    give = np.concatenate([np.zeros(n), np.insert(rows.compliance[active, :, lane], 0, 0, axis=1).ravel()])
    inverse = np.kron(np.linalg.inv(h), np.eye(3))
    add_proximal(give, a @ inverse @ a.T, n, active)
    change = np.linalg.solve(a @ inverse @ a.T + np.diag(give), missing)
    force = np.zeros((n, 3))
    force[active] = -np.einsum("jk,kjc->jc", change[n:].reshape(-1, 3), tangents[:, active])
    z = d @ (free - (inverse @ a.T @ change).reshape(n, 3))
    return change[:n], force, place.T @ force / mass[:, None], z
