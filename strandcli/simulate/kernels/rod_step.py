"""The step of the rod solver over packs of strands: predict, iterate, make lengths exact, set the new velocity.

Each thread takes packs from the work queue (`work_queue.run_workers`) and has scratch of its own. Strands are
independent, so the number of threads changes no bit. A vector of strands goes through all phases of the step before the
next one begins.
"""

from __future__ import annotations

import numpy as np

from ...constants import W
from ...jit import device, function, inlined
from ...simd import (
    any_lane,
    lane_count,
    load,
    load3,
    no_fma,
    store,
    store3,
    vector_pointer_at,
)
from . import (
    rod_contact,
    rod_curl,
    rod_descent,
    rod_energy,
    rod_newton,
    rod_parts,
    rod_start,
    rod_sweep,
)
from .records import (
    FRICTION,
    MOVED,
    ROTATION,
    ROUNDING,
    SHIFTED,
    STEP,
    TRANSLATION,
    TURNED,
    Contact,
    Place,
    Scheme,
)
from .rod_descriptor import (
    AFTER,
    BEFORE,
    BESIDE,
    ITERATIONS,
    SCRATCH,
    SCRATCH_BYTES,
    SEGMENTS,
    flags_of,
    forcing_of,
    material_of,
    solids_of,
    state_of,
)
from .rod_scratch import AXES, EDGE, FIRST_SEGMENT, IMPACT, PACK, ROOT_SHIFT, SEGMENT
from .rod_sweep import ROW
from .work_queue import TASKS, call_beside, take


@function
def single(descriptor, worker):
    """Run the step in single precision, as one of the threads."""
    work(np.float32, descriptor, worker, solids_of, None)


@function
def double(descriptor, worker):
    """Run the step in double precision, as one of the threads."""
    work(np.float64, descriptor, worker, solids_of, None)


@function
def single_crowded(descriptor, worker):
    """Run the step of strands that interact in single precision, as one of the threads."""
    work(np.float32, descriptor, worker, solids_of, True)


@function
def double_crowded(descriptor, worker):
    """Run the step of strands that interact in double precision, as one of the threads."""
    work(np.float64, descriptor, worker, solids_of, True)


@inlined  # machine code that hands on a function's address could not be kept in the cache
def work(kind, descriptor, worker, solids_of, crowded):
    """Move strands by one step in place, pack by pack from the work queue. ``descriptor`` comes from `descriptor_of`,
    all of its arrays of the floating type ``kind``; ``solids_of`` reads the solids from it; ``crowded``: as in `Flags`,
    None compiles nothing of it."""
    scratch = vector_pointer_at(kind, descriptor[SCRATCH] + worker * descriptor[SCRATCH_BYTES])
    state, material, forcing = state_of(kind, descriptor), material_of(kind, descriptor), forcing_of(kind, descriptor)
    flags, solids = flags_of(descriptor, crowded), solids_of(kind, descriptor)
    pack, segments = take(descriptor), descriptor[SEGMENTS]
    while pack < descriptor[TASKS]:
        next_pack = take(descriptor)
        if crowded is not None:
            call_beside(descriptor[BEFORE], descriptor[BESIDE], pack, next_pack, worker)
            state = state_of(kind, descriptor, worker - pack)
        run(scratch, state, material, forcing, flags, solids, descriptor[ITERATIONS], pack, next_pack, segments)
        if pack == descriptor[TASKS] - 1:
            rod_sweep.fill_block(scratch, state.positions, pack, segments)
        if crowded is not None:
            call_beside(descriptor[AFTER], descriptor[BESIDE], pack, next_pack, worker)
        pack = next_pack


@device
def run(scratch, state, material, forcing, flags, solids, iterations, pack, next_pack, n):
    """Step the strands of a ``pack`` with ``n`` segments, a vector of them at a time. The state of ``next_pack`` is
    prefetched; ``scratch`` has `rod_tension.scratch_size` vectors."""
    numbers = forcing.numbers
    contact = Contact(
        solids, flags.solids, flags.segments,
        numbers[STEP] * (1 + 1.5 * numbers[MOVED]), numbers[FRICTION], 0.25 * numbers[ROUNDING], True,
    )  # fmt: skip
    for lane in range(0, PACK, lane_count(scratch)):
        strand = pack * PACK + lane
        position = rod_sweep.position_of(strand, n)
        at = Place(
            n,
            strand,
            pack * n * AXES + lane,
            pack * n * PACK + lane,
            pack * (n + 1) * AXES + lane,
            position,
        )
        place_root(scratch, pack * AXES + lane, position + ROW, state.positions, forcing, flags.deforming)
        touched = flags.solids and any_lane(load(state.touching, strand) > 0.0)
        disturbs = rod_start.disturbs(scratch, state, strand, flags.crowded, touched, flags.curled, numbers)
        scheme = Scheme(numbers[MOVED], touched, disturbs, flags.crowded, contact.duration, flags.curled)
        rod_start.set_coefficients(scratch, at, state, material, forcing, scheme)
        if flags.curled:
            rod_energy.begin(scratch, at, state, material, forcing)
            rod_curl.set_rest(scratch, at, state, material, forcing, scheme)
        rod_start.fill_scratch(scratch, at, state, material, forcing, scheme)
        rod_start.give_way(scratch)
        store(scratch, IMPACT, 0.0)
        worst = rod_newton.iterate(scratch, at, state, material, forcing, scheme, iterations, False)
        met, again, lost = contact, False, worst < 0.0
        if flags.solids:
            worst, pressed, near, lost = rod_contact.find(
                scratch, at, state, material, forcing, scheme, contact, iterations, worst
            )
            scheme, met = rod_contact.pressed_by(scheme, pressed), rod_contact.nearby(contact, near)
            again = rod_parts.able(scheme, numbers) and any_lane(lost)
        worst = rod_descent.mend(scratch, at, state, material, forcing, scheme, iterations, worst)
        store(state.residuals, strand, rod_contact.residual_of(worst))
        if again:
            rod_parts.keep(scratch, at, state, scheme)
        rod_sweep.sweep(scratch, at, next_pack, state, material, numbers, scheme, met)
        if flags.curled:
            rod_energy.keep(scratch, at, state, material, forcing, flags.solids)
        if again:
            rod_parts.make(scratch, at, next_pack, state, material, forcing, scheme, contact, iterations, lost)


@device
def rotated(turn, k, x, y, z):
    """A vector turned by the matrix whose rows begin at place k, rounded as NumPy rounds it."""
    return (
        no_fma(turn[k] * x) + no_fma(turn[k + 1] * y) + no_fma(turn[k + 2] * z),
        no_fma(turn[k + 3] * x) + no_fma(turn[k + 4] * y) + no_fma(turn[k + 5] * z),
        no_fma(turn[k + 6] * x) + no_fma(turn[k + 7] * y) + no_fma(turn[k + 8] * z),
    )


@device
def place_root(s, local, place, positions, forcing, deforming):
    """Set the root's position, its displacement `ROOT_SHIFT`, and the clamped direction as the edge before the first.
    ``local``: place of the strand in (P, 3 S); ``place``: of its root in the positions."""
    pose = forcing.pose
    x, y, z = load3(forcing.roots, local, PACK)
    px, py, pz = rotated(pose, ROTATION, x, y, z)
    store3(positions, place, W, px + pose[TRANSLATION], py + pose[TRANSLATION + 1], pz + pose[TRANSLATION + 2])
    px, py, pz = rotated(pose, TURNED, x, y, z)
    px, py, pz = px + pose[SHIFTED], py + pose[SHIFTED + 1], pz + pose[SHIFTED + 2]
    if deforming:
        dx, dy, dz = load3(forcing.drift, local, PACK)
        px, py, pz = px + dx, py + dy, pz + dz
    store3(s, ROOT_SHIFT, 1, px, py, pz)
    x, y, z = load3(forcing.directions, local, PACK)
    x, y, z = rotated(pose, ROTATION, x, y, z)
    store3(s, FIRST_SEGMENT - SEGMENT + EDGE, 1, x, y, z)
