"""Newton's iteration for the force densities."""

from __future__ import annotations

from ...jit import device
from ...simd import any_lane, broadcast, load, sqrt, store, where
from . import rod, rod_descent, rod_start, rod_tension
from .rod import AXES, FIRST, SEGMENT, T

PATIENCE = 6
"""Iterations after which no edge changes by more than `STRIDES` over the number of iterations since."""
STRIDES = 2.0
WILD = 64.0
"""Error of |e|² above which τ does not start from the step before."""
PULLED = 4.0
RISE = 1.00001
"""Energy that is no more than so many times what it was has not risen but for rounding."""
MEND = 1.5
FINE = 32
"""Segments beyond which an edge that is wrong, as where contact kinks a strand, counts by its share of the strand."""
WHOLE = 3.0
"""How many times the mean error of edges is no less than the worst one's where all are wrong, as where strands whip."""
STUCK = 20
FAST = 1.9
"""Steps with bounded τ are too short where they go on for long, as near a saddle; twice as long is safe."""


@device
def iterate(s, at, state, material, scheme, iterations, enough):
    """Newton's iterations: one, and on until all | |e|² − 1 | are below ``enough``, but no more than ``iterations``;
    returns what they are in the end, the greatest of each lane. In strands of more than `FINE` segments some may be
    greater, if the mean of all is as small as if none were. Begins with x(τ) for the τ of the step before, or, where
    loads turn out to be far greater than that knows of, for more.

    From where H is indefinite in some lane on, iterations are steps of quadratic programming: with H as it is, for τ
    changes it. There energy tells whether a step led anywhere: where it rose, the next one is half as long."""
    n, mass, joint = at.segments, material.mass, material.joint
    worst = broadcast(s, 0.0)
    total = worst
    alone = min(1.0, FINE / n)
    together = WHOLE / n
    share = broadcast(s, 1.0)
    before = broadcast(s, rod.MOST * rod.MOST)
    ever = broadcast(s, 0.0)
    hard = False
    programmed = False
    for count in range(-1, iterations + 1):
        if count > 1 and not any_lane(min(worst, max(alone * worst, together * total)) > enough):
            break
        if count == 0:
            if not any_lane(worst > WILD):
                continue
            pull(s, at, state, mass, scheme)
        stale = programmed
        programmed = count > 0 and (hard or programmed)
        if count > 0:
            far = programmed or any_lane(worst > rod.FAR)
            if far:
                ever = max(ever, load(s, rod.HARD))
                mine = max(ever, worst) > rod.FAR
                energy = rod.retract(s, n, mass, joint, mine)
                if stale:
                    rod_descent.bound(s, n, mass, joint)
                else:
                    rod_descent.descend(s, n, mass, joint, None, None, None)
                if programmed:
                    rose = energy > before * RISE
                    most = where(load(s, rod.HARD) > 0.0, broadcast(s, FAST if count > STUCK else 1.0), 1.0)
                    share = where(mine, where(rose, 0.5 * share, min(MEND * share, most)), 1.0)
                    before = where(mine, energy, before)
            rod_tension.observe(s, n, mass, far)
            if programmed:
                hard = rod_descent.foretell(s, n, mass, joint)
                worst, total = rod.move(s, n, share)
                worst = worst / (share * share)
                total = total / (share * share)
            else:
                hard = rod_descent.settle(s, n, mass, joint, True)
                if count > PATIENCE:
                    rod.shorten(s, n, min(1.0, STRIDES / (count - PATIENCE) / sqrt(rod.longest(s, n))))
                worst, total = rod.move(s, n, None)
        else:
            hard = rod_descent.settle(s, n, mass, joint, None)
            worst, total = rod.move(s, n, None)
    if programmed:
        rod_descent.bound(s, n, mass, joint)
    return worst


@device
def pull(s, at, state, mass, scheme):
    """τ at least what would carry the load if all of it pulled one way, less a few units of mass; both are summed up
    from the tip."""
    x = broadcast(s, 0.0)
    y = x
    z = x
    sum = x
    for j in range(at.segments - 1, -1, -1):
        o = FIRST + j * SEGMENT
        ax, ay, az = rod_start.predict(s, at.edge + j * AXES, state, scheme)
        x += mass[j] * ax
        y += mass[j] * ay
        z += mass[j] * az
        sum += mass[j]
        carried = sqrt(x * x + y * y + z * z) - PULLED * sum
        t = load(s, o + T)
        store(s, o + T, where(carried > 0.0, max(t, carried), t))
