"""The step of the rod solver over packs of strands: predict, iterate, make lengths exact, set the new velocity.

Each thread takes packs from the work queue (`work_queue.run_workers`) and has scratch of its own. A vector of strands
goes through all phases of the step before the next one begins. One whose iterations end without lengths, inside of a
solid, or with an edge that has turned by more than a right angle takes the step again in parts (`parts`).
"""

from __future__ import annotations

from ....constants import W
from ....jit import device, function, inlined
from ....simd import (
    any_lane,
    fused_pointer,
    fused_pointers,
    fused_vector_pointer,
    lane_count,
    load,
    load3,
    shifted,
    sqrt,
    store,
    where,
)
from ...contact.kernels.search import Contact
from . import begin, finish, newton, parts
from .arrays import AXES, PACK, ROW, Place
from .scratch import scratch_at
from .work_queue import TASKS, take


@function
def run(state, material, drive, step, needs, solids, scratch, queue, worker):
    """Move strands by one step in place, pack by pack from the work queue, as one of its workers. ``solids``: rows of
    spheres, capsules, planes and boxes, each row followed by its motion in the step; ``scratch`` (workers, size): zeros
    at first."""
    work(state, material, drive, step, needs, contact_of(solids, None), scratch, queue, worker)


@device
def contact_of(solids, custom):
    """The `Contact` of rows of solids."""
    return Contact(
        (fused_pointer(solids[0]), solids[0].size), (fused_pointer(solids[1]), solids[1].size),
        (fused_pointer(solids[2]), solids[2].size), (fused_pointer(solids[3]), solids[3].size), custom, True, None,
    )  # fmt: skip


@inlined
def work(state, material, drive, step, needs, contact, scratch, queue, worker):
    """`run` among solids as kernels have them."""
    n = state.edges.shape[1]
    base = fused_vector_pointer(scratch)
    lanes = lane_count(base)
    s = scratch_at(shifted(base, worker * (scratch.shape[1] // lanes)), n)
    state, material, drive = fused_pointers(state), fused_pointers(material), fused_pointers(drive)
    pack = take(queue)
    while pack < queue[TASKS]:
        next_pack = take(queue)
        for lane in range(0, PACK, lane_count(s.edge)):
            move(s, place_of(pack, lane, n), next_pack, state, material, drive, step, needs, contact)
        if pack == queue[TASKS] - 1:
            finish.fill_block(s, state.positions, pack, n)
        pack = next_pack


@device
def place_of(pack, lane, n):
    """`Place` of the vector of strands of a pack that begins at a lane."""
    strand = pack * PACK + lane
    return Place(
        n, strand, pack * AXES + lane, pack * n * AXES + lane, pack * n * PACK + lane, pack * (n + 1) * AXES + lane,
        finish.position_of(strand, n),
    )  # fmt: skip


@device
def move(s, at, next_pack, state, material, drive, step, needs, contact):
    """Move a vector of strands, in parts those that do not converge at once."""
    shift = begin.place_root(s, at, state, drive, step, needs.deforming)
    root = load3(state.positions, at.position + ROW, W)
    zero = load(material.lengths, at.strand) * 0.0
    still = zero, zero, zero
    c = begin.coefficients_of(at, state, material, drive, step, needs, 1, still)
    contact = parts.with_shift(contact, True, shift)
    begin.begin(s, at, state, needs, c, shift)
    if needs.pinned:
        begin.aim_tip(s, at, drive, c, 1, still)
    if needs.curled:
        for j in range(at.segments):  # iterations overwrite the twist that the step begins with
            store(s.begun, parts.SAVED * j + parts.TWIST, load(state.twist, at.number + j * PACK))
    worst, depth, near, path = newton.iterate(s, at, state, material, step, needs, c, contact, root)
    bad = parts.badness(s, at, state, worst, depth, path)
    again = any_lane(bad > 1.0)
    if again:
        parts.save(s.begun, at, state, needs, bad >= 0.0, False)
    finish.finish(s, at, next_pack, state, material.bends, step, needs, c, (contact, near), shift)
    if again:
        met = contact, (root, shift)
        worst = parts.improve(s, at, state, material, drive, step, needs, met, (bad, worst))
    store(state.residuals, at.strand, worst / (1.0 + sqrt(1.0 + where(worst > 1.0, worst, -worst))))
