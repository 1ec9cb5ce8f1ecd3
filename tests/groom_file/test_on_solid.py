"""Hair of a file on a head: roots on its surface, no point inside, lengths kept, the rest as it was."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import exchange_kit
import groom_file_kit as kit
from mesh_kit import sphere
from strandcli.errors import UsageError
from strandcli.exchange.strands import Strands
from strandcli.groom.blocks import unpack
from strandcli.groom_file import from_scene
from strandcli.groom_file.on_solid import CLEARANCE, Head, put_on
from strandcli.scene.model.solids import BoxSolid, CapsuleSolid, PlaneSolid, SphereSolid
from strandcli.scene.motion import Pose

RADIUS = 0.1
STILL = Pose(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), (0.0, 0.0, 0.0))
BALL = Head(SphereSolid(name="head", radius=RADIUS), STILL, "head")
CLEAR = CLEARANCE * 2 * RADIUS


def hair(offset: float = 0.0, sink: float = 0.02, strands: int = 300, points: int = 24, seed: int = 1) -> Strands:
    """Strands from a ball's upper half that fall down its sides, and on the way sink into it as deep as asked for;
    their roots are ``offset`` above it."""
    rng = np.random.default_rng(seed)
    polar, turn = np.arccos(rng.uniform(0.2, 1, strands)), rng.uniform(0, 2 * np.pi, strands)
    t = np.linspace(0, 1, points)
    angle = polar[:, None] + 1.2 * t
    radius = RADIUS + offset + 0.01 * np.sin(3 * t) - sink * np.sin(np.pi * t) ** 2 * (np.arange(strands) % 2)[:, None]
    ring = radius * np.sin(angle)
    made = np.stack([ring * np.cos(turn)[:, None], radius * np.cos(angle), ring * np.sin(turn)[:, None]], axis=2)
    return exchange_kit.of(list(made.astype(np.float32)))


def lengths(strands: Strands) -> np.ndarray:
    return np.asarray(strands.lengths())


def depth(strands: Strands) -> np.ndarray:
    """(S, n) distances from the ball's surface."""
    points = strands.points.astype(np.float64).reshape(strands.count, -1, 3)
    return np.asarray(np.linalg.norm(points, axis=2) - RADIUS)


def test_strands_inside_are_led_out_and_the_others_stay() -> None:
    before = hair()
    notes: list[str] = []
    after = put_on(before, BALL, "a.ply", notes)
    inside = (depth(before)[:, 1:] < 0).any(axis=1)
    assert inside.sum() == 150
    near = np.arange(24) >= 3  # where the clearance is whole
    assert depth(after)[:, near].min() >= CLEAR * (1 - 1e-4)
    assert depth(after)[:, 1:].min() > 0
    np.testing.assert_allclose(lengths(after), lengths(before), rtol=1e-4)
    a, b = (one.points.reshape(before.count, -1, 3) for one in (before, after))
    np.testing.assert_array_equal(a[~inside].view(np.int32), b[~inside].view(np.int32))
    np.testing.assert_array_equal(a[:, 0], b[:, 0])
    assert notes == [line for line in notes if "150 strands moved out of head" in line]
    assert "0.0" in notes[0]


@pytest.mark.parametrize("offset", [0.004, -0.003])
def test_roots_are_put_on_the_surface(offset: float) -> None:
    before = hair(offset, sink=0.0)
    notes: list[str] = []
    after = put_on(before, BALL, "a.ply", notes)
    assert np.abs(depth(after)[:, 0]).max() < 1e-7
    assert depth(after)[:, 1:].min() > 0
    np.testing.assert_allclose(lengths(after), lengths(before), rtol=1e-4)
    a, b = (one.points.reshape(before.count, -1, 3) for one in (before, after))
    off = np.linalg.norm(b - a, axis=2)
    np.testing.assert_allclose(off[:, 0], abs(offset), rtol=1e-4)
    assert off.max() < 3 * abs(offset)
    assert f"{before.count:,} strands of {before.count:,} had roots off head" in notes[0]
    assert f"median {abs(offset):.2g} m" in notes[0]


def test_hair_that_fits_keeps_every_bit() -> None:
    given = hair(sink=0.0)
    roots = given.roots().astype(np.float64)
    assert np.abs(np.linalg.norm(roots, axis=1) - RADIUS).max() < 1e-7
    notes: list[str] = []
    assert put_on(given, BALL, "a.ply", notes) is given
    assert notes == []


def test_a_mesh_is_as_its_ball(tmp_path: Path) -> None:
    vertices, triangles = sphere(5)
    file = tmp_path / "ball.obj"
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in RADIUS * vertices]
    file.write_text("\n".join([*lines, *(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles)]) + "\n")
    groom = kit.write(tmp_path / "hair.data", list(hair(0.002).points.reshape(300, -1, 3)))
    made = kit.scene(groom, **solid(file))
    found = from_scene(made)
    points = unpack(found.groom.points[:, 1:], 300)  # type: ignore[index]
    away = np.linalg.norm(points.astype(np.float64), axis=2) - RADIUS
    assert np.abs(away[:, 0]).max() < 1e-4  # chords of the mesh
    assert away[:, 3:].min() > 0.9 * CLEAR
    assert any("moved out of head" in words for words in found.notes)
    assert from_scene(made) is found


def solid(file: Path, **settings: Any) -> dict[str, Any]:
    """Settings of a scene whose hair is put on a mesh."""
    return {"solids": [{"kind": "mesh", "file": str(file), "name": "head", **settings}], "emitter.groom.on": "head"}


@pytest.mark.parametrize(
    "shape",
    [
        CapsuleSolid(radius=0.07, length=0.06), BoxSolid(size=(0.2, 0.15, 0.17)), PlaneSolid(),
        SphereSolid(radius=0.09),
    ],
)  # fmt: skip
def test_all_shapes_have_roots_and_keep_points_out(shape: Any) -> None:
    after = put_on(hair(0.001), Head(shape, STILL, "head"), "a", [])
    x, y, z = after.points.astype(np.float64).reshape(300, -1, 3).transpose(2, 0, 1)
    if isinstance(shape, CapsuleSolid):
        away = np.hypot(np.hypot(x, z), y - np.clip(y, -0.03, 0.03)) - 0.07
    elif isinstance(shape, BoxSolid):
        q = np.stack([np.abs(x) - 0.1, np.abs(y) - 0.075, np.abs(z) - 0.085])
        away = np.linalg.norm(np.maximum(q, 0), axis=0) + np.minimum(q.max(axis=0), 0)
    elif isinstance(shape, PlaneSolid):
        away = y
    else:
        away = np.sqrt(x * x + y * y + z * z) - 0.09
    assert np.abs(away[:, 0]).max() < 1e-6
    assert away[:, 1:].min() > -1e-6


def test_hair_that_lies_elsewhere_is_refused() -> None:
    far = exchange_kit.of(list((100 * hair().points + [100, 0, 0]).astype(np.float32).reshape(300, -1, 3)))
    with pytest.raises(UsageError, match=r"m off head, .* m apart; move, scale or turn one of them"):
        put_on(far, BALL, "a.ply", [])


def test_heads_that_there_are_not_are_refused(tmp_path: Path) -> None:
    groom = kit.write(tmp_path / "hair.data", kit.hanging([5] * 9))
    with pytest.raises(UsageError, match="no solid has the name 'hat'"):
        kit.scene(groom, **{"emitter.groom.on": "hat"})
    with pytest.raises(UsageError, match="is a cone; hair is put on sphere"):
        kit.scene(groom, **{"solids": [{"kind": "cone", "name": "hat"}], "emitter.groom.on": "hat"})
