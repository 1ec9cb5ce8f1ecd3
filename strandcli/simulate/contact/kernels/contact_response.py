"""How far a force moves the particles of a strand within a step: the step of `simulate.rod`, linearised
(`docs/solvers.md`).

With the multipliers η between the particles that they concern, the matrix has a band of 11 beside its diagonal; its
LDLᵀ needs no pivoting, for H is definite (tension only is in it, not compression) and edges are independent.
"""

from __future__ import annotations

from ....jit import device, function
from . import contact_pairs as columns

BLOCK, BAND = 4, 12
"""Unknowns of a particle; numbers of a row of the lower band, entry k is k columns left of the diagonal."""
MULTIPLIER = 3
HELD = 2.0
"""Masses that a solid which a particle touches adds to it along its normal; too many make rounds overshoot."""
LEAST = 1e-12


@device
def add(matrix, i, j, value):
    """Add to the entry of two unknowns, the later one first."""
    matrix[i, i - j] += value


@device
def add_square(matrix, j, k, factors):
    """Add k |x|², x a sum of the particles j, j − 1 and j − 2 with ``factors``."""
    for a in range(columns.AXES):
        if j >= a:
            for b in range(a, columns.AXES):
                if j >= b:
                    for c in range(columns.AXES):
                        add(matrix, BLOCK * (j - a) + c, BLOCK * (j - b) + c, k * factors[a] * factors[b])


@device
def add_bend(matrix, j, k, edges, parts):
    """Add to the entries of particles j, j − 1 and j − 2 the bending of a curved rest shape, k |z_j − M z_{j−1}|² with
    the changes z of both edges, where M z = ((e × z) × f) + z for the edges e and f: rest vectors turn with the edge
    before. ``parts`` (3, 3, 3) is scratch."""
    e, f = edges[j - 1], edges[j]
    cosine = e[0] * f[0] + e[1] * f[1] + e[2] * f[2]
    for c in range(columns.AXES):
        for d in range(columns.AXES):
            one = 1.0 if c == d else 0.0
            turned = cosine * one - e[c] * f[d]
            parts[0, c, d], parts[1, c, d], parts[2, c, d] = one, -one - turned, turned
    for a in range(columns.AXES):
        for b in range(a, columns.AXES):
            if j < b:
                continue
            for c in range(columns.AXES):
                for d in range(columns.AXES if a < b else c + 1):
                    x = 0.0
                    for i in range(columns.AXES):
                        x += parts[a, i, c] * parts[b, i, d]
                    add(matrix, BLOCK * (j - a) + c, BLOCK * (j - b) + d, k * x)


@function
def factorise(strands, edges, loads, mass, joint, curled, bands, parts):
    """Set the factors of ``strands`` (m,), ``bands`` (m, 4 N, `BAND`). ``edges`` (S, N, 3) unit vectors; ``loads``:
    stiffness (S,) and tension (S, N), both times h², and contact of solids (S, N, 3), unit normals or 0; ``mass`` and
    ``joint`` (N,); ``curled``: whether rest shapes are curved; ``parts`` (3, 3, 3) is scratch."""
    stiffness, tension, normals = loads
    for i in range(len(strands)):
        s = strands[i]
        matrix = bands[i]
        matrix[...] = 0.0
        n = len(mass)
        for j in range(n):
            for c in range(columns.AXES):
                add(matrix, BLOCK * j + c, BLOCK * j + c, mass[j])
                for d in range(c + 1):
                    pinned = HELD * mass[j] * normals[s, j, c] * normals[s, j, d]
                    add(matrix, BLOCK * j + c, BLOCK * j + d, pinned)
                add(matrix, BLOCK * j + MULTIPLIER, BLOCK * j + c, edges[s, j, c])
                if j > 0:
                    add(matrix, BLOCK * j + MULTIPLIER, BLOCK * (j - 1) + c, -edges[s, j, c])
            if curled and j > 0:
                add_bend(matrix, j, stiffness[s] * joint[j], edges[s], parts)
            else:
                add_square(matrix, j, stiffness[s] * joint[j], (1.0, -2.0, 1.0))
            add_square(matrix, j, max(tension[s, j], 0.0), (1.0, -1.0, 0.0))
        eliminate(matrix)


@device
def eliminate(matrix):
    """LDLᵀ in place: D on the diagonal, L beside it."""
    for i in range(len(matrix)):
        first = max(0, i - BAND + 1)
        for j in range(first, i):
            value = matrix[i, i - j]
            for k in range(max(first, j - BAND + 1), j):
                value -= matrix[i, i - k] * matrix[j, j - k]
            matrix[i, i - j] = value
        pivot = matrix[i, 0]
        for j in range(first, i):
            value = matrix[i, i - j]
            over = value / matrix[j, 0]
            matrix[i, i - j] = over
            pivot -= over * value
        if abs(pivot) < LEAST:
            pivot = -LEAST if i % BLOCK == MULTIPLIER else LEAST
        matrix[i, 0] = pivot


@device
def substitute(matrix, x):
    """Solve in place, (4 N, 3) right-hand sides."""
    size = len(matrix)
    for i in range(size):
        for j in range(max(0, i - BAND + 1), i):
            for c in range(columns.AXES):
                x[i, c] -= matrix[i, i - j] * x[j, c]
    for i in range(size):
        for c in range(columns.AXES):
            x[i, c] /= matrix[i, 0]
    for i in range(size - 1, -1, -1):
        for j in range(max(0, i - BAND + 1), i):
            for c in range(columns.AXES):
                x[j, c] -= matrix[i, i - j] * x[i, c]


@function
def respond(pairs, numbers, bands, places, lengths, out, x):
    """Set ``out`` (m, 2, N, 3, 3): by how much particles of a pair's first and of its second strand move (metres, next
    to last index) by a unit of force on it at the contact (last index). ``places`` (S,): where each strand's factors
    are; ``lengths`` (S,) of a segment; ``x`` (4 N, 3) is scratch."""
    for i in range(len(pairs)):
        for side in range(2):
            strand = pairs[i, columns.FIRST if side == 0 else columns.SECOND]
            place = pairs[i, columns.FIRST_SEGMENT if side == 0 else columns.SECOND_SEGMENT]
            share = numbers[i, columns.ALPHA if side == 0 else columns.BETA]
            x[...] = 0.0
            for c in range(columns.AXES):
                x[BLOCK * place + c, c] = share / lengths[strand]
                if place > 0:
                    x[BLOCK * (place - 1) + c, c] = (1.0 - share) / lengths[strand]
            substitute(bands[places[strand]], x)
            for j in range(out.shape[2]):
                for c in range(columns.AXES):
                    for d in range(columns.AXES):
                        out[i, side, j, c, d] = x[BLOCK * j + c, d]
