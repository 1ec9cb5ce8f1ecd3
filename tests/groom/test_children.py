"""Children of guides: locks and waves as they are asked for, nothing that depends on how many there are; and from frame
to frame of a run: beside solids, of guides that are lost, drawn."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mesh_kit import obj, sphere
from strand_kit import frames_of, scene_of
from strandcli.draw.common.scratch import Scratch
from strandcli.errors import SimulationError
from strandcli.groom.blocks import lanes, pack, unpack
from strandcli.groom.children import Children
from strandcli.groom.emit import emit
from strandcli.meshes.make import make_mesh
from strandcli.scene.model import Camera, Clump, Scene, Wave
from strandcli.scene.motion import emitter_pose

SCENE = """
seed: 3
emitter: {strands: 300, particles: 9, length: 0.4, shape: {kind: disc, radius: 0.1}, jitter: 20,
  position: [0, 1, 0], rotation: [10, 20, 30]}
children: {count: 7}
rules: [gravity, collision, elasticity]
solids: [{kind: sphere, radius: 0.25, position: [0.2, 1.3, 0]},
  {kind: box, size: [1, 0.2, 1], position: [-0.7, 1.2, 0]}, {kind: plane, position: [0, 0.8, 0]},
  {kind: capsule, radius: 0.05, length: 0.2, position: [0, 1.4, 0.2]}]
"""
LOCKS = (Clump(size=0.05, strength=0.6), Clump(size=0.015, strength=0.8))
WAVES = (Wave(radius=0.01, length=0.1), Wave(radius=0.002, length=0.05, disorder=1))


def family(free: bool = True, **settings: Any) -> tuple[Scene, Children]:
    """A scene, by default without anything to collide with, and its children."""
    scene = scene_of(SCENE)
    scene = dataclasses.replace(scene, children=dataclasses.replace(scene.children, **settings))
    if free:
        scene = dataclasses.replace(scene, rules=(), solids=())
    return scene, Children(scene, emit(scene.emitter, scene.seed))


def bent(scene: Scene, amount: float = 2.0) -> tuple[np.ndarray, np.ndarray]:
    """Guides that bend sideways in arcs, (strands, n, 3) in the world, and the lengths of their segments."""
    groom = emit(scene.emitter, scene.seed)
    rotation, shift = (np.array(part) for part in emitter_pose(scene.emitter, 0.0))
    n = scene.emitter.particles
    rest = groom.lengths.astype(float) / (n - 1)
    at = groom.roots.astype(float)
    rows = [at]
    side = np.cross(groom.directions, [0, 0, 1.0])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    for j in range(n - 1):
        turn = amount * j / n
        at = at + rest[:, None] * (np.cos(turn) * groom.directions + np.sin(turn) * side)
        rows.append(at)
    before = groom.roots - rest[:, None] * groom.directions
    return np.stack([before, *rows], 1) @ rotation.T + shift, rest


def grown(children: Children, guides: np.ndarray, rest: np.ndarray, strands: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """(strands, rows, 3) without the row before the root, and segment lengths (strands,)."""
    strands = strands or children.count
    packed = pack(guides)
    ids = np.sort(children.select(packed)[1])[:strands]
    out, lengths = children.grow(packed, lanes(rest[:, None]), 0.0, ids, Scratch())
    return unpack(out, strands)[:, 1:].astype(float), lengths.reshape(-1)[:strands].astype(float)


def emitted(children: Children) -> Any:
    """Constants of children in the order of emission."""
    return children.family.of(np.argsort(children.family.ids))


def steps(strands: np.ndarray) -> np.ndarray:
    """Lengths of segments, (strands, n − 1)."""
    return np.asarray(np.linalg.norm(np.diff(strands, axis=1), axis=2))


def test_children_do_not_depend_on_how_many_there_are() -> None:
    settings: dict[str, Any] = {"clumps": LOCKS, "waves": WAVES, "cut": 0.3, "undercoat": 0.4}
    guides, rest = bent(family()[0])
    few, _ = grown(family(count=3, **settings)[1], guides, rest)
    many, _ = grown(family(count=20, **settings)[1], guides, rest)
    np.testing.assert_array_equal(many[: len(few)], few)
    np.testing.assert_array_equal(grown(family(count=20, **settings)[1], guides, rest, 1000)[0], many[:1000])


def test_a_lock_lies_in_the_wider_lock_of_its_middle_and_strays_are_as_many_as_asked() -> None:
    _, children = family(count=40, clumps=(LOCKS[0], dataclasses.replace(LOCKS[1], stray=0.2, variation=0)))
    wide, narrow = emitted(children).middles
    for middle in np.unique(narrow):
        assert len(np.unique(wide[narrow == middle])) == 1
    assert len(np.unique(narrow)) > 5 * len(np.unique(wide))
    assert (emitted(children).pulls[1] < 0.5).mean() == pytest.approx(0.2, abs=0.01)


def test_a_lock_waves_as_one_and_cut_lengths_are_even() -> None:
    waves = (Wave(radius=0.004, length=0.08, disorder=0.0),)
    found = emitted(family(clumps=(Clump(size=0.05),), waves=waves, cut=0.5, count=40)[1])
    lock = found.middles[0]
    for middle in np.unique(lock)[:5]:
        assert np.ptp(found.phases[0][lock == middle]) == 0
    assert np.ptp(found.phases[0]) > 3
    np.testing.assert_allclose(np.quantile(found.shares, [0, 0.5, 1]), [0.5, 0.75, 1], atol=0.01)


def test_of_waves_with_a_share_so_many_strands_wave_as_all_would_and_the_others_not_at_all() -> None:
    still, few, all_ = (
        grown(children, *bent(scene))[0]
        for scene, children in (family(waves=waves) for waves in (
            (Wave(radius=0.01, share=1e-9),), (Wave(radius=0.01, share=0.3),), (Wave(radius=0.01, share=1.0),)
        ))
    )  # fmt: skip
    wave = (few == all_).all((1, 2))
    np.testing.assert_array_equal(few[~wave], still[~wave])
    assert (np.abs(all_ - still).max((1, 2)) > 0.001).all()
    assert wave.mean() == pytest.approx(0.3, abs=0.02)


def test_an_undercoat_is_short() -> None:
    _, children = family(undercoat=0.3, undercoat_length=0.5, count=40)
    assert (emitted(children).shares == 0.5).mean() == pytest.approx(0.3, abs=0.01)
    assert (emitted(children).shares == 1.0).mean() == pytest.approx(0.7, abs=0.01)


def test_a_parting_parts_parents() -> None:
    scene = scene_of("""
emitter: {strands: 400, shape: {kind: sphere, radius: 0.1, cap: 90}, comb: [1, 0, -0.2], parting: 0.02}
children: {count: 10, clumps: [{size: 0.05}]}
""")
    children = Children(scene, emit(scene.emitter, scene.seed))
    found = emitted(children)
    front = found.roots[:, 2] > 0.03
    left = found.roots[:, 0] < 0.02
    used = found.weights > 1e-6
    for side in (left, ~left):
        assert (np.where(used, left[found.parents], side[:, None] == left[:, None])[front & side]
                == left[front & side][0]).all()  # fmt: skip
        assert (left[found.middles[0][front & side]] == left[front & side][0]).all()


@pytest.mark.parametrize("guides", [1, 2, 3])
def test_few_guides_are_enough(guides: int) -> None:
    scene = scene_of(f"emitter: {{strands: {guides}, jitter: 10}}\nchildren: {{count: 50, clumps: [{{size: 0.5}}]}}")
    children = Children(scene, emit(scene.emitter, 0))
    drawn, _ = grown(children, *bent(scene))
    assert np.isfinite(drawn).all()
    np.testing.assert_allclose(emitted(children).weights.sum(1), 1, atol=1e-6)


def test_children_go_along_from_frame_to_frame() -> None:
    """What is kept between frames is that of the emitter where it stands."""
    scene = scene_of(SCENE.replace("rotation: [10, 20, 30]}", "keys: [{time: 0, position: [0, 1, 0]}, "
                                   "{time: 1, position: [1, 1, 0], rotation: [0, 90, 0]}]}")
                          .replace("rules: [", "rules: [emitter_motion, "))  # fmt: skip
    scene = dataclasses.replace(scene, children=dataclasses.replace(scene.children, waves=WAVES))
    groom = emit(scene.emitter, scene.seed)
    guides, rest = bent(scene)
    packed, lengths = pack(guides), lanes(rest[:, None])
    kept = Children(scene, groom)
    ids = kept.select(packed)[1]
    for at in (0.0, 0.5, 0.5, 1.0, 0.0):
        fresh = Children(scene, groom).grow(packed, lengths, at, ids, Scratch())
        for one, other in zip(kept.grow(packed, lengths, at, ids, Scratch()), fresh, strict=True):
            np.testing.assert_array_equal(one, other)
    assert np.abs(kept.grow(packed, lengths, 1.0, ids, Scratch())[0][:, 1] - fresh[0][:, 1]).max() > 0.5


def test_children_stay_out_of_the_solids_of_collisions() -> None:
    def depth(strands: np.ndarray) -> np.ndarray:
        ball = 0.25 - np.linalg.norm(strands - [0.2, 1.3, 0], axis=2)
        box = (np.array([0.5, 0.1, 0.5]) - np.abs(strands - [-0.7, 1.2, 0])).min(2)
        axis = np.array([0, 1, 0]) * np.clip(strands[..., 1] - 1.4, -0.1, 0.1)[..., None]
        capsule = 0.05 - np.linalg.norm(strands - [0, 1.4, 0.2] - axis, axis=2)
        return np.stack([ball, box, capsule, 0.8 - strands[..., 1]])[..., 1:].max((0, 2))

    guides, rest = bent(family()[0])
    free, _ = grown(family(clumps=LOCKS, waves=WAVES)[1], guides, rest)
    kept, _ = grown(family(free=False, clumps=LOCKS, waves=WAVES)[1], guides, rest)
    assert depth(free).max() > 0.02
    # where a ball and a box meet, pushing from one into the other and back has no end
    assert depth(kept).max() < 3e-3
    clear = depth(free) < -1e-3
    assert clear.any()
    np.testing.assert_array_equal(kept[clear], free[clear])


def test_children_slide_along_a_mesh_with_their_lengths(tmp_path: Path) -> None:
    """Where they touch it they are as far off as they keep, and their segments are as long as at rest."""
    vertices, triangles = sphere(4)
    (tmp_path / "ball.obj").write_bytes(obj(make_mesh(0.25 * vertices, triangles)))
    mesh = f"{{kind: mesh, file: {tmp_path / 'ball.obj'}, position: [0.2, 1.3, 0], rotation: [30, 0, 50]}}"
    scene = scene_of(SCENE[: SCENE.index("solids:")] + f"solids: [{mesh}]\n")
    scene = dataclasses.replace(scene, children=dataclasses.replace(scene.children, clumps=LOCKS))
    guides, rest = bent(scene)
    free, _ = grown(family(clumps=LOCKS)[1], guides, rest)
    kept, lengths = grown(Children(scene, emit(scene.emitter, scene.seed)), guides, rest)

    def away(strands: np.ndarray) -> np.ndarray:
        return np.asarray(np.linalg.norm(strands - [0.2, 1.3, 0], axis=2) - 0.25)[:, 2:]

    touching = (away(kept) < 0.12 * lengths[:, None]) & (away(free) < 0)
    assert touching.sum() > 500
    assert (away(kept) > -1e-3).all()  # flat triangles and a grid stand for the ball
    np.testing.assert_allclose(steps(kept) / lengths[:, None], 1.0, atol=1e-4)
    before = np.minimum.accumulate(away(free), 1) > 0.02  # up to where they come near it
    assert before.sum() > 500
    np.testing.assert_array_equal(kept[:, 2:][before], free[:, 2:][before])


def test_a_run_goes_on_with_the_children_that_are_left() -> None:
    scene = dataclasses.replace(
        scene_of(SCENE + "image: {size: [40, 30]}\n"), camera=Camera(position=(0, 1.2, 1.5), target=(0, 1.2, 0))
    )
    (before,) = frames_of(scene, 1)
    lost = before.positions.copy()
    lost[7] = np.nan
    (after,) = frames_of(scene, 1, positions=lambda number: lost, keep_going=True)
    assert after.report["counts"]["left_out"] == 1
    assert 0 < 7 * 300 - after.report["counts"]["strands"] < 300
    assert after.image is not None
    lost[:] = np.nan
    lost[200] = before.positions[200]
    scene = dataclasses.replace(scene, children=dataclasses.replace(scene.children, clumps=LOCKS))
    with pytest.raises(SimulationError, match="every child has a guide that is not finite"):
        frames_of(scene, 1, positions=lambda number: lost, keep_going=True)
