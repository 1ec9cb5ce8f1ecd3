"""Poses and keys against closed forms and an independent composition of rotations."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from strandcli.scene.model import BoxSolid, Camera, CameraKey, Emitter, PoseKey, SphereSolid
from strandcli.scene.motion import (
    Pose,
    camera_at,
    emitter_pose,
    multiply,
    rotate,
    rotation_matrix,
    solid_pose,
)

angles = st.floats(-3600, 3600)
turns = st.tuples(angles, angles, angles)


def close(left, right, tolerance: float = 1e-12) -> bool:  # type: ignore[no-untyped-def]
    flat = [tuple(itertools.chain.from_iterable(m)) if isinstance(m[0], tuple) else m for m in (left, right)]
    return all(abs(a - b) <= tolerance for a, b in zip(*flat, strict=True))


def about(axis: int, degrees: float):  # type: ignore[no-untyped-def]
    """A rotation about one axis from the C library's sine and cosine."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return (
        ((1.0, 0.0, 0.0), (0.0, c, -s), (0.0, s, c)),
        ((c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c)),
        ((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)),
    )[axis]


@pytest.mark.parametrize(
    ("turn", "of", "becomes"),
    [
        ((90.0, 90.0, 0.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)),  # to +z about x, then to +x about y
        ((90.0, 0.0, 90.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        ((0.0, 90.0, 90.0), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),  # to +x about y, then to +y about z
        ((720.0, -360.0, 1080.0), (1.0, 2.0, 3.0), (1.0, 2.0, 3.0)),
    ],
)
def test_quarter_turns_are_exact(turn, of, becomes) -> None:  # type: ignore[no-untyped-def]
    assert rotate(rotation_matrix(turn), of) == becomes


@given(turns)
def test_a_rotation_is_rz_ry_rx(turn: tuple[float, float, float]) -> None:
    x, y, z = (about(axis, degrees) for axis, degrees in enumerate(turn))
    assert close(rotation_matrix(turn), multiply(z, multiply(y, x)), 1e-11)


KEYS = (
    PoseKey(time=1.0, position=(0.0, 0.0, 0.0), ease="linear"),
    PoseKey(time=3.0, position=(4.0, 0.0, -2.0), rotation=(0.0, 0.0, 720.0), ease="smooth"),
    PoseKey(time=4.0, position=(4.0, 8.0, -2.0), ease="step"),
    PoseKey(time=5.0, position=(0.0, 0.0, 0.0)),
)


@pytest.mark.parametrize(
    ("time", "position"),
    [
        (-10.0, (0.0, 0.0, 0.0)),
        (1.5, (1.0, 0.0, -0.5)),
        (3.0, (4.0, 0.0, -2.0)),
        (3.25, (4.0, 8 * (3 / 16 - 2 / 64), -2.0)),  # smoothstep: 3 s² - 2 s³ at 1/4
        (3.5, (4.0, 4.0, -2.0)),
        (4.999, (4.0, 8.0, -2.0)),
        (5.0, (0.0, 0.0, 0.0)),
    ],
)
def test_keys_are_eased_by_the_one_that_is_left(time: float, position: tuple[float, float, float]) -> None:
    assert emitter_pose(Emitter(position=(9.0, 9.0, 9.0), keys=KEYS), time).translation == position


def test_a_solid_stands_in_the_world_or_follows_the_emitter() -> None:
    emitter = Emitter(position=(0.0, 0.0, 5.0), rotation=(0.0, 90.0, 0.0))
    alone = SphereSolid(position=(1.0, 0.0, 0.0), rotation=(0.0, 0.0, 90.0))
    assert solid_pose(alone, emitter, 0.0) == Pose(rotation_matrix((0.0, 0.0, 90.0)), (1.0, 0.0, 0.0))
    follower = BoxSolid(position=(1.0, 0.0, 0.0), rotation=(0.0, 0.0, 90.0), follow="emitter")
    pose = solid_pose(follower, emitter, 0.0)
    # the emitter turns +x to -z, and the box's own +x is +y before
    assert pose.translation == (0.0, 0.0, 4.0)
    assert rotate(pose.rotation, (0.0, 1.0, 0.0)) == (0.0, 0.0, 1.0)
    assert rotate(pose.rotation, (1.0, 0.0, 0.0)) == (0.0, 1.0, 0.0)


def test_a_following_solid_moves_by_its_own_keys_within_the_moving_emitter() -> None:
    emitter = Emitter(keys=(PoseKey(time=0.0, ease="linear"), PoseKey(time=1.0, position=(0.0, 2.0, 0.0))))
    keys = (PoseKey(time=0.0, ease="linear"), PoseKey(time=2.0, position=(4.0, 0.0, 0.0)))
    solid = SphereSolid(follow="emitter", keys=keys)
    assert solid_pose(solid, emitter, 0.5).translation == (1.0, 1.0, 0.0)


def test_camera_keys_take_what_they_leave_out_from_the_camera() -> None:
    camera = Camera(
        position=(0.0, 0.0, 5.0),
        target=(0.0, 1.0, 0.0),
        fov=50.0,
        height=3.5,
        keys=(
            CameraKey(time=0.0, fov=20.0, ease="linear"),
            CameraKey(time=2.0, position=(4.0, 0.0, 5.0), height=5.0, ease="linear"),
            CameraKey(time=4.0, target=(0.0, 3.0, 0.0)),
        ),
    )
    assert camera_at(camera, 0.0) == ((0.0, 0.0, 5.0), (0.0, 1.0, 0.0), 20.0, 3.5)
    assert camera_at(camera, 1.0) == ((2.0, 0.0, 5.0), (0.0, 1.0, 0.0), 35.0, 4.25)
    assert camera_at(camera, 3.0) == ((2.0, 0.0, 5.0), (0.0, 2.0, 0.0), 50.0, 4.25)
    assert camera_at(camera, 9.0) == ((0.0, 0.0, 5.0), (0.0, 3.0, 0.0), 50.0, 3.5)
