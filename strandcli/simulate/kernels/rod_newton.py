"""Newton's iterations for the force densities τ of a rod's step."""

from __future__ import annotations

from ...jit import device
from ...simd import any_lane, broadcast, load, sqrt, store, where
from . import rod, rod_elimination, rod_start, rod_tension
from .records import TOLERANCE
from .rod_scratch import AXES, FIRST_SEGMENT, INDEFINITE, SEGMENT, TENSION

PATIENCE = 6
"""Iterations after which changes of edges are limited: to `STRIDES` over the number of iterations since."""
STRIDES = 2.0
WILD = 64.0
"""Error of |e|² above which τ does not start from that of the step before."""
PULLED = 4.0
"""Units of mass by which `raise_tension` stays below the load that an edge may carry."""
RISE = 1.00001
"""Factor of energy up to which a rise is rounding."""
STEP_GROWTH = 1.5
"""Factor by which a step grows after one that has not raised the energy."""
FINE = 32
"""Segments beyond which a single wrong edge, as where contact kinks a strand, counts by its share of the strand."""
EVEN = 3.0
"""Ratio of the worst edge's error to the mean, which it hardly exceeds where all edges are wrong, as when a strand
whips."""
STUCK = 20
"""Iterations after which steps with bounded τ may be longer than 1."""
LONGEST_STEP = 1.9
"""Their greatest length then. Steps with bounded τ are too short, as near a saddle; twice as long is safe."""


@device
def iterate(s, at, state, material, forcing, scheme, iterations, again):
    """Solve for τ and the edges by Newton's method; returns the greatest | |e|² − 1 | of each lane.

    Begins with x(τ) for the τ of the step before, or for a greater one where loads turn out to be far greater than it
    knows of. Then come one iteration and more, up to ``iterations``, until all | |e|² − 1 | are below ``tolerance``; in
    strands of more than `FINE` segments some may be greater, where the mean of all is small enough.

    From where H is indefinite in some lane on, iterations are steps of sequential quadratic programming: H is that of
    the present τ, not of the changed one. Energy is the merit function: a step after one that raised it is halved.

    ``again``: whether this goes on from the last τ and edges of the same step, with other forces.
    """
    n, mass, joint, tolerance = at.segments, material.mass, material.joint, forcing.numbers[TOLERANCE]
    curled = scheme.curled
    worst = total = ever_indefinite = broadcast(s, 0.0)
    single_share = min(1.0, FINE / n)
    mean_share = EVEN / n
    step = broadcast(s, 1.0)
    past_energy = broadcast(s, rod.GREATEST_ERROR * rod.GREATEST_ERROR)
    indefinite = again and any_lane(load(s, INDEFINITE) > 0.0)
    quadratic = False  # whether iterations are steps of quadratic programming
    for count in range(1 if again else -1, max(iterations, 1) + 1):
        if count > 1 and not any_lane(min(worst, max(single_share * worst, mean_share * total)) > tolerance):
            break
        if count == 0:
            if not any_lane(worst > WILD):
                continue
            raise_tension(s, at, state, mass, scheme)
        refactorise = quadratic
        quadratic = count > 0 and (indefinite or quadratic)
        if count > 0:
            far = quadratic or any_lane(worst > rod.FAR)
            loaded = count == 1 and again
            if loaded:
                set_loads(s, n, mass, joint, curled, False)
            if far:
                ever_indefinite = max(ever_indefinite, load(s, INDEFINITE))
                chosen = max(ever_indefinite, worst) > rod.FAR
                energy = rod.retract(s, n, mass, joint, curled, chosen)
                set_loads(s, n, mass, joint, curled, refactorise)
                if quadratic:
                    step = next_step(s, step, chosen, energy > past_energy * RISE, count)
                    past_energy = where(chosen, energy, past_energy)
            rod_tension.filter_forward(s, n, mass, far or loaded, True, None)
            if quadratic:
                indefinite = rod_elimination.change_tension(s, n, mass, joint, curled)
                worst, total = apply_step(s, n, step)
            else:
                indefinite = rod_elimination.factorise(s, n, mass, joint, curled, True)
                if count > PATIENCE:
                    limit_change(s, n, STRIDES / (count - PATIENCE))
                worst, total = rod.apply_change(s, n, None)
        else:
            indefinite = rod_elimination.factorise(s, n, mass, joint, curled, None)
            worst, total = rod.apply_change(s, n, None)
    if quadratic:
        rod_elimination.factorise_bounded(s, n, mass, joint, curled)
    return worst


@device
def set_loads(s, n, mass, joint, curled, refactorise):
    """Set the loads of the present edges and τ, and the pivots too where ``refactorise``."""
    if refactorise:
        rod_elimination.factorise_bounded(s, n, mass, joint, curled)
    else:
        rod_elimination.set_loads(s, n, mass, joint, curled)


@device
def limit_change(s, n, most):
    """Scale the loads so that no edge changes by more than ``most``."""
    rod.scale_loads(s, n, min(1.0, most / sqrt(rod.greatest_change_squared(s, n))))


@device
def apply_step(s, n, step):
    """`rod.apply_change`; the errors that it returns are over step², what they would be of a whole step."""
    worst, total = rod.apply_change(s, n, step)
    return worst / (step * step), total / (step * step)


@device
def next_step(s, step, chosen, rose, count):
    """Length of the next step of quadratic programming in the ``chosen`` lanes, 1 in the others: half as long where the
    energy ``rose``, else longer, at most 1, or `LONGEST_STEP` where that has gone on for long."""
    most = where(load(s, INDEFINITE) > 0.0, broadcast(s, LONGEST_STEP if count > STUCK else 1.0), 1.0)
    return where(chosen, where(rose, 0.5 * step, min(STEP_GROWTH * step, most)), 1.0)


@device
def raise_tension(s, at, state, mass, scheme):
    """Raise τ to the size of the summed load beyond each edge, less `PULLED` times the mass beyond it: what the edge
    would carry if the strand lay along the load."""
    x = broadcast(s, 0.0)
    y = x
    z = x
    mass_beyond = x
    for j in range(at.segments - 1, -1, -1):
        o = FIRST_SEGMENT + j * SEGMENT
        ax, ay, az = rod_start.predict(s, at.edge + j * AXES, state, scheme)
        x += mass[j] * ax
        y += mass[j] * ay
        z += mass[j] * az
        mass_beyond += mass[j]
        carried = sqrt(x * x + y * y + z * z) - PULLED * mass_beyond
        t = load(s, o + TENSION)
        store(s, o + TENSION, where(carried > 0.0, max(t, carried), t))
