"""What the strands around do to a strand: friction toward the grid's velocity, and pressure.

A strand loses a share of its velocity against the cells', an average of velocities: it can gain no energy, however
great the share. What it loses the rest gain, for a cell's velocity is its momentum over its mass, by the same weights.
The impulse of pressure on the face of two cells is shared by masses, half of it by those of both cells, half by what
lies between their middles. So sums of momentum stay, to rounding.
"""

from __future__ import annotations

import numpy as np

from ....jit import device
from ....jit.indices import FIRST, SECOND, THIRD
from ....simd import (
    any_lane,
    broadcast,
    gather4,
    half_width_pointer,
    lane_count,
    load,
    load3,
    pointer,
    store,
    store3,
    store_records,
    where,
)
from ....simd.vectors import add_scaled, dot, less, scaled
from ...rod.kernels.arrays import AXES, PACK
from . import records as rec
from .pressure import BETWEEN_ONLY, HELD, WIDELY, moved
from .records import beside
from .transfer import cell_of, locate, three, weights_along

CHANGED = np.float32(0.25)
"""Share of its acceleration by those around that changes in a step, from which on a strand is jolted."""
SLIGHT = np.float32(0.1)
"""Share of a strand's velocity against its tip by which that change at least changes velocities then."""
LONGEST = np.float32(1 / 60)
"""Seconds: of shorter steps both shares are less in proportion, for the same motion changes less in one."""
FARTHEST = np.float32(1e4)
"""Cells a step by which those around push a strand on at the most, for the next grid."""

EMPTY = np.float32(1e-30)
"""Metres in a cell up to which it is empty."""


@device
def shelter(box, mass, numbers, left, behind):
    """Set the share of the wind that is ``left`` in each cell (cells,), and ``behind`` it.

    Air that goes through strands of density n (metres in a cubic metre) and thickness d is left with exp(−n d s) of
    its velocity after a path s. The share in a cell is the mean of those behind the cells upwind along each axis,
    weighted by the wind's components; it passes 1 / (1 + τ + τ² / 2) of it with τ = n d s, which has the same bits
    on every machine. ``mass`` (cells,): metres in them."""
    wide, high, deep = box[rec.SIZE], box[rec.SIZE + 1], box[rec.SIZE + 2]
    x, y, z = numbers[rec.WIND], numbers[rec.WIND + 1], numbers[rec.WIND + 2]
    total = abs(x) + abs(y) + abs(z)
    a, b, c, stop = abs(x) / total, abs(y) / total, abs(z) / total, numbers[rec.STOP] / total
    step, row, layer = (1 if x > 0 else -1), (wide if y > 0 else -wide), (wide * high if z > 0 else -wide * high)
    open = np.float32(1)
    for k in range(deep):
        for j in range(high):
            begin = ((k if z > 0 else deep - 1 - k) * high + (j if y > 0 else high - 1 - j)) * wide
            for i in range(wide):
                at = begin + (i if x > 0 else wide - 1 - i)
                share = a * (behind[at - step] if i > 0 else open)
                share += b * (behind[at - row] if j > 0 else open)
                share += c * (behind[at - layer] if k > 0 else open)
                depth = stop * mass[at]
                left[at] = share
                behind[at] = share / (1 + depth + np.float32(0.5) * depth * depth)


@device
def find_targets(box, o, near, grid, room, numbers, pressure, targets):
    """Set the targets of layer o. A cell that no sample reaches has none."""
    wide, high, deep = box[rec.SIZE], box[rec.SIZE + 1], box[rec.SIZE + 2]
    cells, out = pointer(grid), pointer(targets)
    for row in range(o * high, (o + 1) * high):
        if not near[o, row % high]:
            continue
        for i in range(0, wide, rec.LANES):
            at = row * wide + i
            if any_lane(load(cells, rec.MASS * grid.shape[1] + at) > 0.0):
                found = targets_of(at, beside(row, i, wide, high, deep), grid, room, numbers, pointer(pressure))
                store_records(out, rec.CELL * at, found)
            else:
                for c in range(rec.CELL):
                    store(out, rec.CELL * at + c * rec.LANES, 0.0)


@device
def targets_of(at, sides, grid, room, numbers, pressure):
    """The columns of the targets of a vector of cells, with `records`' steps to the cells on their ``sides``."""
    cells, count, full = pointer(grid), grid.shape[1], numbers[rec.FULL]
    m = load(cells, rec.MASS * count + at)
    rate = numbers[rec.LOST] * min(m / full, 1.0)
    f = rate / max(m, EMPTY)
    u, v, w = load3(cells, rec.MOMENTUM * count + at, count)
    between, all = rec.BETWEEN * count + at, (at, numbers, cells, pressure, pointer(room.aperture))
    near_x, wide_x = pushes(all, sides[0], between)
    near_y, wide_y = pushes(all, sides[1], between + count)
    near_z, wide_z = pushes(all, sides[2], between + 2 * count)
    u, v, w = f * u + wide_x, f * v + wide_y, f * w + wide_z
    if len(room.left) > 0:
        lost = load(pointer(room.left), at) - 1.0
        u, v, w = (
            u + lost * numbers[rec.CHANGE],
            v + lost * numbers[rec.CHANGE + 1],
            w + lost * numbers[rec.CHANGE + 2],
        )
    return rate, u, v, w, near_x, near_y, near_z, m * 0.0


@device
def pushes(all, sides, between):
    """Change of velocity, m/s, by the pressure on the faces along an axis: of what lies between the middles of cells
    and of the next ones, and of the cells. ``between``: place of the first one's column along the axis."""
    at, numbers, cells, pressure, apertures = all
    before, after, (a, b, _, _) = sides
    none, full = broadcast(cells, 0.0), numbers[rec.FULL]
    m, p, own = load(cells, at), load(pressure, at), load(apertures, at)
    next = p - load(pressure, at + after)
    next = own * load(apertures, at + after) * next / moved(m, load(cells, at + after), load(cells, between), full)
    past, columns = load(pressure, at + before) - p, load(cells, between + before)
    past = own * load(apertures, at + before) * past / moved(m, load(cells, at + before), columns, full)
    next, past, push = where(b, next, none), where(a, past, none), numbers[rec.SPEED] * full
    return push * BETWEEN_ONLY * next, push * WIDELY * (next + past)


@device
def accelerate_part(moving, samples, part, cells):
    """Set the accelerations of particles of a part of the strands, and what `note` does."""
    work, box = (cells.scratch[part], cells.found[part]), cells.boxes[len(cells.parts)]
    for pack in range(cells.parts[part, rec.FIRST], cells.parts[part, rec.LAST]):
        packs = pack, pack + 1
        accelerate_pack(moving, samples, packs, box, cells.targets, work, cells.shares, cells.accelerations)
        note(moving, samples, pack, cells.accelerations)


@device
def accelerate_pack(moving, samples, packs, box, targets, work, shares, accelerations):
    """Set the accelerations of a pack's particles: each sample's change of momentum goes to the particles of which it
    is a mean, by their shares. The emitter takes up what goes to the root.
    ``packs``: as `locate` takes them."""
    wide = np.uint64(box[rec.SIZE] * rec.CELL)
    layer = wide * np.uint64(box[rec.SIZE + 1])
    cells, (rows, found), begun = half_width_pointer(targets), work, np.int64(0)
    read = half_width_pointer(found)
    for sample in range(len(samples.first)):
        locate(moving, samples, packs, sample, box, samples.origins[-1], rows)
        for k in range(PACK):
            a, c, d = three(rows, rec.SHARE, k)
            store(read, k * rec.CELL, blend(cells, cell_of(rows, k), wide, layer, a, c, d))
        rate, u, v, w = gather4(pointer(found), 0, load(pointer(rec.COUNTED), 0), rec.CELL, 0.0)
        x, y, z, _ = gather4(pointer(found), rec.PUSH, load(pointer(rec.COUNTED), 0), rec.CELL, 0.0)
        store(pointer(found), rec.CELL * PACK, rate)
        store3(pointer(found), (rec.CELL + 1) * PACK, PACK, u + x, v + y, w + z)
        for c in range(rec.FOUND - rec.CELL):
            for k in range(PACK):
                rows[rec.RESULT + c, k] = found[(rec.CELL + c) * PACK + k]
        begun = share_out(samples, packs[0], sample, rows, shares[sample], begun, accelerations)


@device
def share_out(samples, pack, sample, rows, shares, begun, accelerations):
    """Add what a sample's velocity changes by to the accelerations of its particles, of which so many have ``begun``;
    return how many have then."""
    read, out = pointer(rows), pointer(accelerations)
    n, first, count = accelerations.shape[1], samples.first[sample] - 1, samples.counts[sample]
    for k in range(0, PACK, lane_count(read)):
        lost = scaled(load(read, rec.RESULT * PACK + k), load3(read, rec.VELOCITY * PACK + k, PACK))
        change = less(load3(read, (rec.RESULT + 1) * PACK + k, PACK), lost)
        for i in range(max(-first, 0), count):
            at, share = (pack * n + first + i) * 3 * PACK + k, shares[i]
            own = scaled(share, change)
            if first + i < begun:
                own = add_scaled(load3(out, at, PACK), share, change)
            store3(out, at, PACK, own[0], own[1], own[2])
    return first + count


@device
def blend(cells, at, wide, layer, a, c, d):
    """The columns of targets interpolated between eight cells, of which ``at`` is the first."""
    x, x_next = weights_along(cells, FIRST, a)
    y, y_next = weights_along(cells, SECOND, c)
    z, z_next = weights_along(cells, THIRD, d)
    sums = y * z * blend_row(cells, at, x, x_next)
    sums += y_next * z * blend_row(cells, at + wide, x, x_next)
    sums += y * z_next * blend_row(cells, at + layer, x, x_next)
    return sums + y_next * z_next * blend_row(cells, at + layer + wide, x, x_next)


@device
def blend_row(cells, at, x, x_next):
    """Interpolate along x."""
    return x * load(cells, at) + x_next * load(cells, at + np.uint64(rec.CELL))


@device
def note(moving, samples, pack, accelerations):
    """Set `Moving.unloaded`, `Moving.pushed` and `Moving.jolted` of a pack, whose accelerations are set."""
    velocity, change, unloaded = pointer(moving.velocity), pointer(accelerations), pointer(moving.unloaded)
    pushed, n, step = pointer(moving.pushed), accelerations.shape[1], samples.step
    seen, most = (1 - HELD) * step, FARTHEST / (samples.inverse * step)
    share = min(step / LONGEST, 1.0)
    least, slight = share * CHANGED, share * SLIGHT / step
    for lane in range(0, PACK, lane_count(change)):
        past = changed = speed = broadcast(change, 0.0)
        tip = load3(velocity, (pack * n + n - 1) * AXES + lane, PACK)
        for at in range(pack * n * AXES + lane, (pack + 1) * n * AXES + lane, AXES):
            own, push, before = load3(velocity, at, PACK), load3(change, at, PACK), load3(pushed, at, PACK)
            x, y, z = scaled(seen, push)
            x, y, z = min(max(x, -most), most), min(max(y, -most), most), min(max(z, -most), most)
            store3(unloaded, at, PACK, own[0] + x, own[1] + y, own[2] + z)
            store3(pushed, at, PACK, push[0], push[1], push[2])
            more, away = less(push, before), less(own, tip)
            past += dot(before, before)
            changed += dot(more, more)
            speed += dot(away, away)
        much = (changed > least * least * past) & (changed > slight * slight * speed)
        store(pointer(moving.jolted), pack * PACK + lane, where(much, broadcast(change, 1.0), 0.0))
