"""The arrays of a rod solver at its start: what strands are made of, how they lie, what they are at rest, and where
their tips are pinned.

P packs of S = `PACK` strands with N segments each, as `kernels.arrays` has them. Pinned tips are hinges about places
that the emitter carries along: such a particle weighs so much that nothing moves it, and its free displacement is the
displacement to its place."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...groom.blocks import aligned, lanes, on_large_pages
from ...groom.record import Groom
from ...scene.motion import Pose
from .kernels.arrays import PACK, Drive, Material, Needs, State
from .material import matter_along, stiffness, torsion
from .rest_shape import coiled, hold, straight, transported, unit_edges
from .surroundings import gravity

if TYPE_CHECKING:
    from ...scene.model import Scene
    from .surroundings import Surroundings

Floats = NDArray[np.float64]

CLAMP, ANCHOR = 2.0, 1e-3
"""Relative rigidity against twist of a clamped root, with half a segment before its joint, and a hinged one."""
HINGE = 1e-9
"""Relative rigidity of a hinged root whose strand is curled: its reaction is written as a bend of that joint."""


class Matter(NamedTuple):
    """What the strands of a scene are made of."""

    lengths: Floats
    """(strands,) of a segment, metres."""
    stiffness: Floats
    """(strands,) B / (ρ A ℓ⁴), 1/s²."""
    mass: Floats
    """(N,) of particles, relative."""
    joint: Floats
    """(N,) rigidity of joints, relative."""


class Shape(NamedTuple):
    """How strands lie at the start, in the emitter's frame, and which of their rest shapes."""

    axes: Floats
    """(strands, 3) unit vectors along which they are clamped."""
    edges: list[Floats]
    """N arrays (strands, 3) of unit vectors, root to tip."""
    mended: bool
    """Whether some edge differs from the groom's."""
    curled: bool
    """Whether rest shapes are curved."""
    coiled: bool
    """Whether some strand is a coil."""


class Rest(NamedTuple):
    """Curved rest shapes, and what else a sag-free start needs; arrays are packed."""

    bends: NDArray[Any]
    """As `Material.bends`."""
    twist: NDArray[Any]
    """As `State.twist`."""
    tension: NDArray[Any]
    """As `State.tension`."""
    stiffness: Floats
    """(strands,) 1/s²: the material's, or greater where a sag-free start asks for more."""


def packed(rows: NDArray[np.floating], dtype: Any) -> NDArray[Any]:
    """(strands, k) values a strand -> (P, k S)."""
    return lanes(rows, dtype, PACK)


def matter_of(scene: Scene, groom: Groom) -> Matter:
    """The material of a scene's strands, by segments."""
    n = scene.emitter.particles - 1
    lengths = groom.lengths.astype(np.float64) / n
    return Matter(lengths, stiffness(scene.rod, lengths), *matter_along(scene.rod, n))


def shape_of(scene: Scene, groom: Groom, dtype: Any) -> Shape:
    """The strands' shape at the start. For a sag-free start edges have unit length to double precision, and in single
    precision count as mended: not even rounding may move strands."""
    rest = scene.rod.rest
    axes = groom.directions.astype(np.float64)
    edges, mended = unit_edges(groom, scene.emitter.particles - 1)
    if rest == "sag_free":
        mended = mended or dtype == np.float32
        edges = [edge / np.linalg.norm(edge, axis=1, keepdims=True) for edge in edges]
    bent = rest != "straight" and not straight([axes, *edges])
    curled = bent or rest == "sag_free"
    return Shape(axes, edges, mended, curled, curled and coiled(edges))


def needs_of(scene: Scene, shape: Shape, around: Surroundings, deforming: bool) -> Needs:
    """What a step of the scene needs, tips not being pinned."""
    rules = {use.name for use in scene.rules}
    return Needs(
        shape.curled, around.any_solids, around.segments, deforming, False,
        "interaction" in rules or "contact" in rules, "contact" in rules,
    )  # fmt: skip


def world_edges(shape: Shape, pose: Pose) -> Iterator[Floats]:
    """The edges of a shape in the world, (strands, 3) each: one at a time, since all take much memory."""
    turn = np.array(pose.rotation)
    return (edge @ turn.T for edge in shape.edges)


def rest_of(scene: Scene, shape: Shape, matter: Matter, pose: Pose, dtype: Any) -> Rest:
    """The rest shapes of strands, and what balances their weight where they are to start sag-free."""
    n, strands = len(shape.edges), len(matter.lengths)
    packs = -(-strands // PACK)
    rows = packs if shape.curled else 1
    bends, twist = aligned((rows, n + 1, 3 * PACK), dtype), aligned((rows, n, PACK), dtype)
    tension = aligned((packs, n, PACK), dtype)
    if not shape.curled:
        return Rest(bends, twist, tension, matter.stiffness)
    edges = np.stack(shape.edges)
    targets = np.diff(np.concatenate([shape.axes[None], edges]), axis=0)
    angles, stiffer = np.zeros((n, strands)), matter.stiffness
    if scene.rod.rest == "sag_free":
        pull = np.array(pose.rotation).T @ gravity(scene) / matter.lengths[:, None]
        # masses as the kernel reads them: what they are rounded by would be a load
        mass, joint = (row.astype(dtype).astype(np.float64) for row in (matter.mass, matter.joint))
        balance = hold(shape.axes, edges, mass, joint, matter.stiffness, torsion(scene.rod, shape.coiled), pull)
        angles, stiffer, targets = balance.twist, balance.stiffness, targets - balance.bends
        for j, force in enumerate(balance.tension):
            tension[:, j] = packed(force[:, None], dtype)
    across, local = transported(shape.axes, edges, targets, angles)
    bends[:, 0] = packed(across, dtype)
    for j, target in enumerate(local):
        bends[:, j + 1] = packed(target, dtype)
        twist[:, j] = packed(angles[j][:, None], dtype)
    return Rest(bends, twist, tension, stiffer)


def state_of(positions: NDArray[Any], edges: Iterable[Floats], rest: Rest, needs: Needs, dtype: Any) -> State:
    """The state of strands at rest, at ``positions`` with these ``edges`` in the world; arrays that are not needed have
    one pack."""
    packs, n, _ = rest.tension.shape
    rows = on_large_pages((packs, n, 3 * PACK), dtype)
    for j, edge in enumerate(edges):
        rows[:, j] = packed(edge, dtype)

    def zeros(needed: bool) -> NDArray[Any]:
        return on_large_pages((packs if needed else 1, n, 3 * PACK), dtype)

    if dtype != np.float32:
        single = positions
        positions = on_large_pages(single.shape, dtype)
        positions[...] = single
    return State(
        edges=rows,
        velocity=zeros(True),
        before=zeros(True),
        ahead=zeros(True),
        moved=zeros(True),
        tension=rest.tension,
        force=zeros(needs.solids),
        share=aligned((packs if needs.solids and needs.segments else 1, n, PACK), dtype),
        restart=aligned((packs, PACK), dtype),
        acceleration=zeros(needs.pushed),
        jolted=aligned((packs if needs.pushed else 1, PACK), dtype),
        twist=rest.twist,
        positions=positions,
        residuals=np.zeros((packs, PACK), dtype),
    )


def material_of(matter: Matter, rest: Rest, dtype: Any) -> Material:
    """The material as the kernel reads it."""
    return Material(
        packed(matter.lengths[:, None], dtype), packed(rest.stiffness[:, None], dtype), matter.mass.astype(dtype),
        matter.joint.astype(dtype), rest.bends,
    )  # fmt: skip


def drive_of(groom: Groom, packs: int, dtype: Any, needs: Needs) -> Drive:
    """What moves strands, before a first step."""
    drifting = groom.roots if needs.deforming else groom.roots[:1]
    return Drive(
        packed(groom.roots, dtype), packed(groom.directions, dtype), np.ones((packs, PACK), dtype),
        packed(np.zeros_like(drifting), dtype), aligned((packs, 3 * PACK), dtype),
    )  # fmt: skip


HEAVY = 1e6
"""Factor of a pinned particle's mass."""
TOLERANCE = 1e-6
"""Error of |e|² at which iterations stop, in single precision: what is left moves tips off their places."""


class Pins:
    """Where tips are pinned: ``places`` (P, 3, `PACK`) metres in the emitter's frame."""

    def __init__(self, state: State, material: Material, drive: Drive, pose: Pose) -> None:
        """Pins tips where they are, with the emitter in a pose."""
        self._lengths = material.lengths
        self._longest = material.lengths.astype(np.float64) * state.edges.shape[1]
        away = self._ends(state, drive, pose) - np.array(pose.translation)[:, None]
        self.places = np.einsum("ji,pjk->pik", np.array(pose.rotation), away)

    def aim(self, state: State, drive: Drive, poses: tuple[Pose, Pose]) -> None:
        """Set `Drive.tips` to the displacement of tips to where they are to be at the end of a step, with the emitter
        in two ``poses``, at the begin and the end."""
        roots, goals = (self._placed(one, poses[1]) for one in (drive.roots.reshape(-1, 3, PACK), self.places))
        far, most = np.linalg.norm(goals - roots, axis=1), self._longest
        # no iteration finds lengths for a place out of reach, nor with slack for a taut strand that is shaken
        goals = roots + (goals - roots) * np.minimum(1, most / np.maximum(far, most))[:, None]
        drive.tips[...] = (goals - self._ends(state, drive, poses[0])).reshape(drive.tips.shape)

    def _ends(self, state: State, drive: Drive, pose: Pose) -> NDArray[np.float64]:
        """Return (P, 3, `PACK`) where edges lead from roots, for positions are rounded more far from the origin."""
        edges = state.edges.sum(1, dtype=np.float64).reshape(len(state.edges), 3, PACK)
        return self._placed(drive.roots.reshape(-1, 3, PACK), pose) + edges * self._lengths[:, None]

    @staticmethod
    def _placed(points: NDArray[Any], pose: Pose) -> NDArray[np.float64]:
        """Return points (P, 3, `PACK`) of the emitter's frame, with the emitter in a pose."""
        turn, shift = np.array(pose.rotation), np.array(pose.translation)
        return np.einsum("ij,pjk->pik", turn, points.astype(np.float64)) + shift[:, None]
