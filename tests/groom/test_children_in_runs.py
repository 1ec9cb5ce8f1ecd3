"""Children from frame to frame of a run: beside solids, of guides that are lost, drawn."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from mesh_kit import obj, sphere
from strand_kit import frames_of, scene_of
from strandcli.draw.common.scratch import Scratch
from strandcli.errors import SimulationError
from strandcli.groom.blocks import lanes, pack
from strandcli.groom.children import Children
from strandcli.groom.emit import emit
from strandcli.meshes.make import make_mesh
from strandcli.scene.model import Camera
from tests.groom.test_children import LOCKS, SCENE, WAVES, bent, family, grown, steps


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
    assert before.positions is not None
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
