"""The step of the rod solver over packs of strands: predict, iterate, make lengths exact, set the new velocity.

Each thread takes packs from the work queue (`jit.tasks`) and has scratch of its own. A vector of strands
goes through all phases of the step before the next one begins. One whose iterations end without lengths, inside of a
solid, or with an edge that has turned by more than a right angle takes the step again in parts (`parts`).
"""

from __future__ import annotations

from ....constants import W
from ....jit import device, function
from ....jit.indices import NO, YES
from ....jit.pruned import by_type
from ....jit.tasks import TASKS, take
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
from ....solids import COLUMNS
from ...contact.kernels.search import Contact, Custom
from . import begin, finish, parts
from .arrays import AXES, PACK, ROW, Place
from .scratch import scratch_at


@function
def run(state, material, drive, step, needs, solids, scratch, queue, worker):
    """Move strands by one step in place, pack by pack from the work queue, as one of its workers. ``solids``: as
    `contact_of` takes them; ``scratch`` (workers, size): zeros at first."""
    n, contact = state.edges.shape[1], contact_of(solids)
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
def contact_of(solids):
    """The `Contact` of rows of spheres, capsules, planes and boxes, each row followed by its motion in the step, and of
    rows and data of custom solids, if there are any."""
    return Contact(
        (fused_pointer(solids[0]), solids[0].size), (fused_pointer(solids[1]), solids[1].size),
        (fused_pointer(solids[2]), solids[2].size), (fused_pointer(solids[3]), solids[3].size), custom_of(solids), True,
        None,
    )  # fmt: skip


@by_type
def custom_of(solids):
    """The `Custom` of these."""
    if len(solids) <= len(COLUMNS):
        return lambda solids: None
    form = solids[len(COLUMNS)].instance_class
    return lambda solids: Custom(
        form(fused_pointer(solids[4][0]), *solids[4][1:]), solids[4][0].size, solids[4][0].shape[1]
    )


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
    """Move a vector of strands: by a whole step, or the best of more attempts where that is bad. ``next_pack``: that of
    which the state is prefetched."""
    shift = begin.place_root(s, at, state, drive, step, needs.deforming)
    met = contact, (load3(state.positions, at.position + ROW, W), shift)
    if needs.curled:
        for j in range(at.segments):  # iterations overwrite the twist that the step begins with
            store(s.begun, parts.SAVED * j + parts.TWIST, load(state.twist, at.number + j * PACK))
    best = worst = restart = load(material.lengths, at.strand) * 0.0
    in_parts = best < 0.0
    attempts = 0
    for count in range(parts.LAST + 1):
        pressed = count < parts.LAST
        chosen = best > 1.0 if pressed else (best > 1.0) & (worst > (parts.GRAVE if needs.curled else parts.LOST))
        if count > 0:
            if not any_lane(chosen) or not (pressed or needs.solids or needs.curled):
                break
            if count == 1:
                parts.copy(s.best, at, state, needs, ~in_parts, YES, NO)
            parts.copy(s.begun, at, state, needs, chosen, YES, YES)
            next_pack = at.strand // PACK
        least = where(chosen, best, 0.0)
        how = min(1 << count, parts.MOST_PARTS), pressed, next_pack, least
        bad, error = parts.attempt(s, at, state, material, drive, step, needs, met, how)
        attempts += 1
        if count == 0:
            best, worst, restart = bad, error, load(state.restart, at.strand)
        else:
            better = bad < least
            parts.copy(s.best, at, state, needs, better, YES, NO)
            best, worst, in_parts = where(better, bad, best), where(better, error, worst), in_parts | better
    if attempts > 1:
        parts.copy(s.best, at, state, needs, in_parts, YES, YES)
        store(state.restart, at.strand, where(in_parts, 1.0, restart))
    store(state.residuals, at.strand, worst / (1.0 + sqrt(1.0 + where(worst > 1.0, worst, -worst))))
