"""What energy curled strands may have in steps in which nothing drives them.

Rest shapes enter a step by their forces, not by its matrix (`rod_curl`). Where they change too fast for that, as those
of curls with few segments a turn, steps may raise the energy of motion, weight, bending and twist. A strand may have
what it had before its first step without a driver; one that has more in all takes the next step by Euler's method,
which damps what is fast and hardly what is slow. Where motion and weight alone have more, all velocities are scaled (as
by Dinev et al. 2018, "FEPR: Fast Energy Projection for Real-Time Simulation").

Twist follows bends by a step. So what the next iteration for ψ takes of its energy does not count, ½ gᵀ H⁻¹ g by the
torques g and the matrix H of that iteration, as the elimination has it.
"""

from __future__ import annotations

from ...jit import device, function
from ...simd import any_lane, broadcast, load, load3, sqrt, store, where
from ...simd.turning import cosine_sine
from . import rod_curl
from .records import DRAG, FREE, GRAVITY, ROOT_TWIST, TORSION, VELOCITY_STEP
from .rod_frames import CLAMP, carried, first_normal
from .rod_scratch import AXES, PACK
from .rod_tension import TINY

UNKNOWN = 1e30
"""Energy of strands that are driven."""
RIPPLE = 0.05
"""Share of the kinetic energy by which the energy of motion that steps resolve goes up and down."""
EXCESS = 0.1
"""Energy over m g L by which all of it may be more. Bends that rest shapes are late for come and go."""
SLACK = 0.004
"""The same of motion and weight alone."""


@function
def begin(s, at, state, material, forcing):
    """Before a step set `State.energy` of strands that have been driven up to then and are no more."""
    most = load(state.energy, at.strand)
    driven = most >= 0.5 * UNKNOWN
    if forcing.numbers[FREE] > 0 and any_lane(driven):
        kinetic, height, elastic, _ = energies(s, at, state, material, forcing)
        store(state.energy, at.strand, where(driven, kinetic + height + elastic, most))


@function
def keep(s, at, state, material, forcing, solids):
    """Keep the energy of strands at the end of a step from growing: set `State.energy` and `State.calmed`, and scale
    velocities."""
    numbers, strand = forcing.numbers, at.strand
    zero = broadcast(s, 0.0)
    if not numbers[FREE] > 0:
        store(state.energy, strand, broadcast(s, UNKNOWN))
        store(state.calmed, strand, zero)
        return
    kinetic, height, elastic, scale = energies(s, at, state, material, forcing)
    found = kinetic + height + elastic
    most = load(state.energy, strand)
    if solids:
        most = where(load(state.touching, strand) > 0.0, found, most)
    store(state.energy, strand, most)
    store(state.calmed, strand, where(found > most + EXCESS * scale + RIPPLE * kinetic, broadcast(s, 1.0), zero))
    left = most + SLACK * scale - height
    if any_lane(kinetic > left):
        slow_down(at, state, where(kinetic > left, sqrt(max(left, 0.0) / max(kinetic, TINY)), 1.0))


@device
def slow_down(at, state, share):
    """Scale velocities, and the displacement and velocities that BDF2 goes on with."""
    for j in range(at.segments):
        row = at.edge + j * AXES
        for c in range(3):
            p = row + c * PACK
            store(state.velocity, p, share * load(state.velocity, p))
            store(state.before, p, share * load(state.before, p))
            store(state.ahead, p, share * load(state.ahead, p))
            store(state.moved, p, share * load(state.moved, p))


@device
def energies(s, at, state, material, forcing):
    """Energies of strands, of motion, of weight, and of bending and twist; and m g L."""
    numbers = forcing.numbers
    n, bend, joint, torsion = at.segments, at.bend, material.joint, numbers[TORSION]
    zero = broadcast(s, 0.0)
    gx, gy, gz = numbers[GRAVITY], numbers[GRAVITY + 1], numbers[GRAVITY + 2]
    kinetic, height, elastic = zero, zero, zero
    down, total, past = zero, zero, zero
    tx, ty, tz = load3(s, CLAMP, 1)
    ax, ay, az = first_normal(forcing.pose, material.bends, bend)
    angle = zero
    share = zero  # of the torque about the edge before, what goes on to this one
    torque = zero
    rigid = zero
    for j in range(n):
        row = at.edge + j * AXES
        ex, ey, ez = load3(state.edges, row, PACK)
        vx, vy, vz = load3(state.velocity, row, PACK)
        down += gx * ex + gy * ey + gz * ez
        height -= material.mass[j] * down
        total += material.mass[j]
        kinetic += material.mass[j] * (vx * vx + vy * vy + vz * vz)
        u, v, w = load3(material.bends, bend + (j + 1) * AXES, PACK)
        c, d = cosine_sine(angle)
        bx, by, bz = ty * az - tz * ay, tz * ax - tx * az, tx * ay - ty * ax
        f, g = ax * ex + ay * ey + az * ez, bx * ex + by * ey + bz * ez
        x, y, z = tx * (ex - tx) + ty * (ey - ty) + tz * (ez - tz) - u, c * f + d * g, c * g - d * f
        turn, stiff = rod_curl.torque(y, z, v, w)
        y, z = y - v, z - w
        elastic += joint[j] * (x * x + y * y + z * z)
        following = load(state.twist, at.tension + j * PACK)
        if j > 0:
            before = torsion * (joint[j - 1] if j > 1 else numbers[ROOT_TWIST])
            after = torsion * joint[j] if j + 1 < n else 0.0
            f = angle - past
            elastic += before * (f * f)
            torque = joint[j] * turn - before * f + after * (following - angle) + share * torque
            rigid = before * (1.0 - share) + after + joint[j] * stiff
            elastic -= torque * torque / rigid
            share = after / rigid
        past = angle
        angle = following
        rate = 1.0 / max(1.0 + tx * ex + ty * ey + tz * ez, rod_curl.LEAST_FOLD)
        ax, ay, az = carried(ax, ay, az, (rate * (tx + ex), rate * (ty + ey), rate * (tz + ez)), (ex, ey, ez))
        tx = ex
        ty = ey
        tz = ez
    length = load(material.lengths, at.strand)
    over = 1.0 / (1.0 + numbers[DRAG] * numbers[VELOCITY_STEP])  # of masses
    pull = sqrt(broadcast(s, gx * gx + gy * gy + gz * gz))
    rigid = 0.5 * length * length * load(material.stiffness, at.strand)
    return 0.5 * over * kinetic, over * length * height, rigid * elastic, over * total * length * (pull * n)
