"""The law of contact with friction, as observations of a strand's state in the filter of `tension` (`docs/solvers.md`).

A place on segment j, a share σ from its beginning, moves by y_j − (1 − σ) z_j. Where a solid touches it,

    gap + n·change = 0    and    slip_t + change_t + R F_t + P (F_t − F_t') = 0,

F being the force, F' that of the iteration before, n the outward normal, slip how far the place has moved on the solid
in this step, R the compliance of Coulomb's cone, and P a share of the place's mobility m. With F̂_t = F_t − slip_t / m,

    R = max(0, |m F̂_t| − m µ F_n) / (µ F_n).

In a corner of two solids the first tangent leads to the second one, whose gap is observed in place of slip.
"""

from __future__ import annotations

from ....jit import inlined
from ....simd import load, load3, sqrt, store, store3, where
from ....simd.vectors import (
    add_scaled,
    cross,
    dot,
    less_outer,
    less_symmetric,
    matrix_product,
    scaled,
    sum_of,
    symmetric_product,
)

TINY = 1e-20
PROXIMAL = 0.1
"""P over the trace of the place's mobility along the tangents."""
SLIPPERY = 1e6
"""Compliance, segments a unit of force, of places that nothing presses."""


@inlined
def set_wanted(s, j, contact, slip, friction, late):
    """Set what the filter is to observe of segment j: residuals along the normal and both tangents, and compliances.
    ``contact``: normal, first tangent, gap, whether there is a second solid, and its gap along the tangent; ``late``:
    compliance and mobility together change by a geometric mean. Returns by how much the slip is off what the force of
    friction stands for."""
    n, one, gap, corner, corner_gap = contact
    other = cross(n, one)
    force = load3(s.force, 3 * j, 1)
    mobility = load(s.mobility, j)
    first, second = dot(force, one), dot(force, other)
    slip_one, slip_other = dot(slip, one), dot(slip, other)
    x, y = where(corner, 0.0, mobility * first - slip_one), mobility * second - slip_other
    cone = friction * (dot(force, n) + where(corner, abs(first), 0.0))
    beyond = max(sqrt(x * x + y * y) - mobility * cone, 0.0)
    compliance = min(beyond / max(cone, TINY), SLIPPERY)
    if late:  # else sliding and pressure may answer each other without end
        last = load(s.compliance, 2 * j + 1)
        mean = sqrt((compliance + mobility) * (last + mobility)) - mobility
        compliance = where(max(last, compliance) < SLIPPERY, mean, compliance)
    own = where(corner, 0.0, compliance)
    store(s.compliance, 2 * j, own)
    store(s.compliance, 2 * j + 1, compliance)
    first, second = slip_one + own * first, slip_other + compliance * second
    store3(s.wanted, 3 * j, 1, gap, where(corner, corner_gap, first), second)
    error = max(where(corner, 0.0, abs(first)), abs(second))
    return error * mobility / (mobility + compliance)


@inlined
def observe(s, j, covariances, means, whole):
    """Take the contact of segment j into account: along the normal, and then along both tangents together. Returns the
    covariances and the means of the state after that. ``whole``: whether places may be elsewhere than at the end."""
    n, one = load3(s.normal, 3 * j, 1), load3(s.across, 3 * j, 1)
    other = cross(n, one)
    mask = load(s.active, j)
    w = 1.0 - load(s.share, j)
    particle, mixed, edge = covariances
    direction = load3(s.edge, 3 * j, 1)
    mean, mean_edge = means
    h, k = responses(covariances, n, w, whole)
    h1, k1 = responses(covariances, one, w, whole)
    h2, k2 = responses(covariances, other, w, whole)
    # along the normal
    own = along(n, h, k, w, whole)
    p = 1.0 / max(own, TINY)
    s1, s2 = p * along(one, h, k, w, whole), p * along(other, h, k, w, whole)
    h1, k1 = add_scaled(h1, -s1, h), add_scaled(k1, -s1, k)
    h2, k2 = add_scaled(h2, -s2, h), add_scaled(k2, -s2, k)
    # both tangents, given the normal
    a, b, d = along(one, h1, k1, w, whole), along(other, h1, k1, w, whole), along(other, h2, k2, w, whole)
    set_mobility(s, j, (a, b, d), (k1, k2), symmetric_product(edge, direction), (p, k))
    proximal = PROXIMAL * (a + d)
    a += load(s.compliance, 2 * j) + where(load(s.corner, j) > 0.0, 0.0, proximal)
    d += load(s.compliance, 2 * j + 1) + proximal
    q = mask / max(a * d - b * b, TINY * TINY)
    a, b, d = q * d, -q * b, q * a
    p = mask * p
    residual, first, second = load3(s.wanted, 3 * j, 1)
    seen = p * (residual - along(n, mean, mean_edge, w, whole))
    mean, mean_edge = add_scaled(mean, seen, h), add_scaled(mean_edge, seen, k)
    first -= along(one, mean, mean_edge, w, whole)
    second -= along(other, mean, mean_edge, w, whole)
    first, second = a * first + b * second, b * first + d * second
    store3(s.contact_innovation, 3 * j, 1, seen, first, second)
    mean = add_scaled(add_scaled(mean, first, h1), second, h2)
    mean_edge = add_scaled(add_scaled(mean_edge, first, k1), second, k2)
    g, e = scaled(p, h), scaled(p, k)
    g1, e1 = sum_of(scaled(a, h1), scaled(b, h2)), sum_of(scaled(a, k1), scaled(b, k2))
    g2, e2 = sum_of(scaled(b, h1), scaled(d, h2)), sum_of(scaled(b, k1), scaled(d, k2))
    keep_gains(s, 18 * j, g, e)
    keep_gains(s, 18 * j + 6, g1, e1)
    keep_gains(s, 18 * j + 12, g2, e2)
    particle = less_symmetric(less_symmetric(less_symmetric(particle, g, h), g1, h1), g2, h2)
    mixed = less_outer(less_outer(less_outer(mixed, g, k), g1, k1), g2, k2)
    edge = less_symmetric(less_symmetric(less_symmetric(edge, e, k), e1, k1), e2, k2)
    return (particle, mixed, edge), (mean, mean_edge)


@inlined
def set_mobility(s, j, matrix, with_edge, spread, normal):
    """Keep the mobility of the place along the last force of friction, given the length of its own segment, which the
    filter observes next. ``matrix``: of the place along both tangents; ``with_edge``: covariances of these with the
    edge; ``spread``: of the edge along itself with the edge; ``normal``: precision of the normal's observation, and its
    covariance with the edge."""
    a, b, d = matrix
    p, k = normal
    direction = load3(s.edge, 3 * j, 1)
    x, y, z = dot(direction, with_edge[0]), dot(direction, with_edge[1]), dot(direction, k)
    over = 1.0 / max(dot(direction, spread) - p * z * z, 0.01 * load(s.pivot, j))
    proximal = PROXIMAL * (a + d)
    a, b, d = a - over * x * x, b - over * x * y, d - over * y * y
    force = load3(s.force, 3 * j, 1)
    one = load3(s.across, 3 * j, 1)
    u, v = dot(force, one), dot(force, cross(load3(s.normal, 3 * j, 1), one))
    size = max(u * u + v * v, TINY)
    along = (a * u * u + 2.0 * b * u * v + d * v * v) / size
    along = where(u * u + v * v > TINY, along, 0.5 * (a + d))
    along = where(load(s.corner, j) > 0.0, d - b * b / max(a, proximal), along)
    store(s.mobility, j, max(along, TINY) + proximal)


@inlined
def responses(covariances, a, w, whole):
    """Covariances of the change of a place along a with that of the particle and of the edge."""
    particle, mixed, edge = covariances
    # of y with z is `mixed`, by rows of y
    x, y, z = a
    h = symmetric_product(particle, a)
    k = (
        mixed[0] * x + mixed[3] * y + mixed[6] * z, mixed[1] * x + mixed[4] * y + mixed[7] * z,
        mixed[2] * x + mixed[5] * y + mixed[8] * z,
    )  # fmt: skip
    if whole:
        h = add_scaled(h, -w, matrix_product(mixed, a))
        k = add_scaled(k, -w, symmetric_product(edge, a))
    return h, k


@inlined
def along(a, particle, edge, w, whole):
    """How far a place moves along a by a particle's and an edge's changes."""
    x = dot(a, particle)
    if whole:
        x -= w * dot(a, edge)
    return x


@inlined
def keep_gains(s, o, particle, edge):
    """Keep the gains of one observation."""
    store3(s.contact_gain, o, 1, particle[0], particle[1], particle[2])
    store3(s.contact_gain, o + 3, 1, edge[0], edge[1], edge[2])


@inlined
def change_force(s, j, particle, edge, mass, whole):
    """The filter's adjoint of the contact of segment j: change its force, and with it u* of both particles; return the
    adjoints of the means of its ``particle`` and its ``edge`` before the contact."""
    w = 1.0 - load(s.share, j)
    n, one = load3(s.normal, 3 * j, 1), load3(s.across, 3 * j, 1)
    other = cross(n, one)
    seen, first, second = load3(s.contact_innovation, 3 * j, 1)
    first -= dot(load3(s.contact_gain, 18 * j + 6, 1), particle) + dot(load3(s.contact_gain, 18 * j + 9, 1), edge)
    second -= dot(load3(s.contact_gain, 18 * j + 12, 1), particle) + dot(load3(s.contact_gain, 18 * j + 15, 1), edge)
    change = sum_of(scaled(first, one), scaled(second, other))
    particle = sum_of(particle, change)
    if whole:
        edge = add_scaled(edge, -w, change)
    seen -= dot(load3(s.contact_gain, 18 * j, 1), particle) + dot(load3(s.contact_gain, 18 * j + 3, 1), edge)
    particle = add_scaled(particle, seen, n)
    if whole:
        edge = add_scaled(edge, -w * seen, n)
    add_force(s, j, scaled(-1.0, add_scaled(change, seen, n)), mass, whole)
    return particle, edge


@inlined
def add_force(s, j, change, mass, whole):
    """Add to the force of contact on segment j, and what that makes of u* of both its particles; a root is pinned."""
    share = load(s.share, j)
    force = sum_of(load3(s.force, 3 * j, 1), change)
    store3(s.force, 3 * j, 1, force[0], force[1], force[2])
    push(s, j, scaled(share * (1 / mass[j]), change))
    if whole and j > 0:
        push(s, j - 1, scaled((1.0 - share) * (1 / mass[j - 1]), change))


@inlined
def push(s, j, by):
    """Add to u* of a particle."""
    free, left = sum_of(load3(s.free, 3 * j, 1), by), sum_of(load3(s.inertial, 3 * j, 1), by)
    store3(s.free, 3 * j, 1, free[0], free[1], free[2])
    store3(s.inertial, 3 * j, 1, left[0], left[1], left[2])
