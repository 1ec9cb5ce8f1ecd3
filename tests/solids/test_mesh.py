"""Solids that are meshes: a finely tessellated ball against the sphere, whose every answer is known."""

from __future__ import annotations

import gc
import os
import weakref
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mesh_kit
from shadow_kit import soft_visibility
from strand_kit import warned
from strandcli.constants import W
from strandcli.draw.common.kernels import batch, surface_batch
from strandcli.draw.common.kernels.light_columns import LIGHT_SIZE
from strandcli.draw.shadows.kernels import penumbra
from strandcli.draw.shadows.kernels.solid_shadows import soft_shadows
from strandcli.draw.solids.kernels import rays
from strandcli.errors import UsageError
from strandcli.groom.emit import emit
from strandcli.mesh_file import prepared as mesh_data
from strandcli.mesh_file.kernels import arrays
from strandcli.mesh_file.prepared import key_of, mesh_of, prepared
from strandcli.scene import SceneError, loads
from strandcli.scene.model import Emitter, SphereSolid
from strandcli.simulate import advice
from strandcli.simulate.rod.solver import RodSolver
from strandcli.simulate.rules import registry
from strandcli.simulate.thesis.solver import ThesisSolver
from strandcli.solid_shapes.mesh import MeshKey, Settings
from strandcli.solids import Solids, pack_all

STILL = Emitter()
FAR, SKIN = np.float32(1e3), np.float32(1e-2)
R = 0.5
AT = (0.2, -0.1, 0.3)


@pytest.fixture(scope="session")
def balls(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Path]:
    """Files of balls of radius .5 by how often they are refined."""
    folder = tmp_path_factory.mktemp("balls")
    return {n: mesh_kit.write(folder / f"ball_{n}.obj", *mesh_kit.ball(n, R)) for n in (3, 4, 5)}


def settings(path: Path, **more: Any) -> Settings:
    return Settings(file=str(path), **more)


def packed(*solids: Any) -> Solids:
    return pack_all(list(solids), STILL, 0.0)


def test_rays_meet_it_as_they_meet_the_sphere(balls: dict[int, Path]) -> None:
    random = np.random.default_rng(1)
    ways = random.normal(size=(300, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    exact = packed(SphereSolid(radius=R, position=AT))
    worst, slanted = {}, {}
    for n, path in balls.items():
        solids = packed(settings(path, position=AT, rotation=(10.0, 20.0, 30.0)))
        off, lean = [], []
        for way in ways:
            o, d = AT - 2 * way + 0.2 * random.normal(size=3), way
            ray = (*o.astype(np.float32), *d.astype(np.float32))
            found, expected = float(rays.meet(solids, 0, *ray)), float(rays.meet(exact, 0, *ray))
            assert np.isfinite(found) == np.isfinite(expected) or not np.isfinite(found + expected)
            if not np.isfinite(found + expected):
                continue
            point = (o + found * d).astype(np.float32)
            normal, true = np.array(rays.normal(solids, 0, *point)), (point - AT) / np.linalg.norm(point - AT)
            off.append(abs(np.linalg.norm(point - AT) - R))
            lean.append(float(np.linalg.norm(normal - true)))
        assert len(off) > 150
        worst[n], slanted[n] = max(off), max(lean)
    assert worst[5] < 3e-4
    assert min(worst[3] / worst[4], worst[4] / worst[5]) > 3  # as the square of the edges
    assert slanted[5] < 6e-3
    assert slanted[3] > 3 * slanted[5]


def test_distance_and_normal_of_contact_are_those_of_the_sphere(balls: dict[int, Path]) -> None:
    random = np.random.default_rng(2)
    points = AT + random.uniform(-0.9, 0.9, (2000, 3)) * R * 1.5
    away = np.linalg.norm(points - AT, axis=1)
    worst = {}
    for n, path in balls.items():
        depth = advice.depth(points, settings(path, position=AT, rotation=(0.0, 70.0, 0.0)), STILL)
        worst[n] = np.abs(depth - (R - away))[(away < 1.4 * R) & (away > 0.1 * R)].max()
    assert worst[5] < 6e-4
    assert worst[3] > 4 * worst[5]
    coarse = advice.depth(points, settings(balls[5], position=AT, resolution=32), STILL)
    assert worst[5] < np.abs(coarse - (R - away))[(away < 1.4 * R) & (away > 0.1 * R)].max() < 6e-3


def test_hard_shadows_are_those_of_the_sphere(balls: dict[int, Path]) -> None:
    """Also of points on its surface, and of roots a little below it."""
    random = np.random.default_rng(3)
    exact, solids = packed(SphereSolid(radius=R, position=AT)), packed(settings(balls[5], position=AT))
    seen = [0, 0]
    for k in range(600):
        way = random.normal(size=3)
        way /= np.linalg.norm(way)
        out = random.normal(size=3)
        out /= np.linalg.norm(out)
        far = (random.uniform(1.2, 3), 1.0, 1.0 - 0.4 * float(SKIN) / R)[k % 3]
        point = (AT + far * R * out).astype(np.float32)
        side = float(way @ out)
        miss = abs(float(np.linalg.norm(point - AT - ((point - AT) @ way) * way)) - R)
        if (k % 3 > 0 and abs(side) < 0.3) or (k % 3 == 0 and miss < 1.2 * SKIN):
            continue  # at the terminator, and where light goes less than SKIN deep through the sphere
        lit = [float(rays.visibility(one, *point, *way.astype(np.float32), FAR, SKIN)) for one in (solids, exact)]
        assert lit[0] == lit[1], (k, far, side)
        seen[int(lit[0])] += 1
    assert min(seen) > 100


def test_soft_shadows_are_those_of_the_sphere(balls: dict[int, Path]) -> None:
    exact, solids = packed(SphereSolid(radius=R, position=AT)), packed(settings(balls[5], position=AT))
    up = np.array([0, 1, 0], np.float32)
    off = []
    for across in np.linspace(0, 1, 81):
        point = np.array(AT) + np.array((across * 0.8, -1.5, across * 0.6))
        ray = penumbra.LightRay(*point.astype(np.float32), *up, FAR)
        share = [float(soft_visibility(one, ray, SKIN, np.float32(0.1), np.float32(0))) for one in (solids, exact)]
        off.append(abs(share[0] - share[1]))
    assert max(off) < 0.12
    assert float(np.mean(off)) < 0.01


@pytest.mark.parametrize("count", [W, 53])
def test_many_rays_at_once_see_as_much_as_each_alone(balls: dict[int, Path], count: int) -> None:
    """Where rays go along the surface, too, and in lights whose cones leave the grid's box late."""
    random = np.random.default_rng(5)
    solids = packed(*(settings(balls[4], position=at, rotation=(20, 0, 50)) for at in (AT, (-0.9, 0.2, 0.1))))
    out, ways = random.normal(size=(2, count, 3))
    out /= np.linalg.norm(out, axis=1)[:, None]
    ways -= 0.9 * (np.arange(count) % 2)[:, None] * out
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    points = AT + R * np.where(np.arange(count) % 2 > 0, random.uniform(1, 2.5, count), 1.01)[:, None] * out
    work = np.zeros((surface_batch.ROWS, W), np.float32)
    work[batch.X // W : batch.X // W + 3, :count] = points.T
    work[batch.LX // W : batch.LX // W + 3, :count] = ways.T
    work[batch.REACH // W], work[batch.ARRIVES // W] = FAR, 1
    lights = np.zeros((1, 16), np.float32)
    lights[0, LIGHT_SIZE] = 0.3
    soft_shadows(work.reshape(-1), count, lights, 0, solids, SKIN)
    rays_ = [penumbra.LightRay(*one, FAR) for one in np.hstack([points, ways]).astype(np.float32)]
    alone = np.array([soft_visibility(solids, ray, SKIN, np.float32(0.3), np.float32(0)) for ray in rays_])
    assert np.abs(work[batch.ARRIVES // W, :count] - alone).max() < 1e-4
    assert min((alone == 0).sum(), (alone == 1).sum(), ((alone > 0) & (alone < 1)).sum()) > count / 10


STRANDS = """
solver: {solver}
time: {{preroll: 0, fps: 30, frames: 20, substeps: 2}}
image: {{size: 8x8}}
emitter: {{strands: 64, length: 1.2, particles: 16, shape: {{kind: disc, radius: 0.4}}, position: [0, 0.9, 0],
  rotation: [180, 0, 0]}}
rules: [{rules}]
solids: [{solid}]
"""


@pytest.mark.parametrize(("solver", "collision"), [
    ("rod", "collision"), ("rod", "{collision: {segments: true}}"), ("thesis", "collision"),
    ("thesis", "{collision: {segments: true}}"),
])  # fmt: skip
def test_strands_rest_on_it_as_on_the_sphere(balls: dict[int, Path], solver: str, collision: str) -> None:
    rules = f"gravity, {collision}" if solver == "rod" else f"gravity, elasticity, {collision}"
    runs, errors = [], []
    for solid in (f"{{kind: mesh, file: {balls[5]}}}", f"{{kind: sphere, radius: {R}}}"):
        scene = loads(STRANDS.format(solver=solver, rules=rules, solid=solid), rules=registry())
        made: Any = (RodSolver if solver == "rod" else ThesisSolver)(scene, emit(scene.emitter, scene.seed))
        made.advance(20)
        runs.append(made.particles())
        errors.append(made.errors(20))
    points = runs[0][:, 1:].reshape(-1, 3).astype(float)
    under = R - np.linalg.norm(points, axis=1)
    assert under.max() < 2e-3  # of the true sphere, by as much as the mesh and its grid are off
    assert (np.abs(under) < 2e-3).sum() > 50  # many lie on it
    assert errors[0]["penetration_max"] < 1e-3
    assert errors[0]["segment_penetration_max"] == pytest.approx(errors[1]["segment_penetration_max"], abs=4e-3)
    middle = [float(np.median(np.linalg.norm(run[:, -1] - (0, -0.3, 0), axis=1))) for run in runs]
    assert solver == "thesis" or middle[0] == pytest.approx(middle[1], rel=0.05)


def test_roots_inside_are_told(balls: dict[int, Path]) -> None:
    text = STRANDS.format(
        solver="rod", rules="gravity, collision", solid=f"{{kind: mesh, file: {balls[3]}, position: [0, 0.9, 0]}}"
    )
    assert any("swallows the roots" in line for line in warned(text))


def test_the_data_is_made_once_and_follows_the_file(balls: dict[int, Path], tmp_path: Path) -> None:
    one, same = settings(balls[3]), settings(balls[3], position=AT)
    made = mesh_data.data([one, same], 0.0)
    assert all(a is b for a, b in zip(made, mesh_data.data([one, same], 0.5), strict=True))
    assert (made.table[0] == made.table[1]).all()  # once for both
    assert made.table[0, arrays.TRIANGLES] == len(mesh_of(one).triangles)
    both = mesh_data.data([one, settings(balls[4])], 0.0)
    assert both.table[1, arrays.TRIANGLES] == made.table[0, arrays.TRIANGLES] * 4
    path = mesh_kit.write(tmp_path / "one.obj", *mesh_kit.ball(2))
    before = mesh_data.data([settings(path)], 0.0)
    mesh_kit.write(path, *mesh_kit.ball(3))
    os.utime(path, ns=(1, 1))
    after = mesh_data.data([settings(path)], 0.0)
    assert after.table[0, arrays.TRIANGLES] == 4 * before.table[0, arrays.TRIANGLES]


def test_a_table_keeps_its_arrays(balls: dict[int, Path]) -> None:
    made = prepared(key_of(settings(balls[3])))._replace(faces=np.full((512, 3), 7.0, np.float32))
    row, held = mesh_data.columns(made)
    watched = weakref.ref(next(one for one in held if one is made.faces))
    table = mesh_data.that_keeps(np.array([row], np.int64), held)
    del made, held
    gc.collect()
    part = table[0]
    del table
    gc.collect()
    assert watched() is not None
    del part
    gc.collect()
    assert watched() is None


def test_several_meshes_are_met_by_themselves(balls: dict[int, Path], tmp_path: Path) -> None:
    cube = mesh_kit.write(tmp_path / "cube.obj", 0.4 * mesh_kit.cube()[0], mesh_kit.cube()[1])
    solids = packed(settings(cube, position=(-2.0, 0.0, 0.0)), settings(balls[4], position=(2.0, 0.0, 0.0)))
    for x, m, half in ((-2.0, 0, 0.4), (2.0, 1, R)):
        ray = (np.float32(x), np.float32(0.1), np.float32(5), *np.array([0, 0, -1], np.float32))
        t = float(rays.meet(solids, m, *ray))
        assert 5 - t == pytest.approx(half if m == 0 else np.sqrt(R * R - 0.01), abs=3e-3)
        assert not np.isfinite(float(rays.meet(solids, 1 - m, *ray)))
    assert advice.depth(np.array([[-2.0, 0, 0.3]]), settings(cube, position=(-2.0, 0.0, 0.0)), STILL)[
        0
    ] == pytest.approx(0.1, abs=2e-3)


def test_it_deforms_from_file_to_file(tmp_path: Path) -> None:
    """A ball that moves and grows: rays, distances and strands follow; halfway it is the mean of both."""
    vertices, triangles = mesh_kit.ball(4, R)
    small = mesh_kit.write(tmp_path / "small.obj", vertices * 0.9, triangles)
    large = mesh_kit.write(tmp_path / "large.obj", vertices * 1.1 + (0.1, 0, 0), triangles)
    keys = (MeshKey(time=0.0, file=str(small)), MeshKey(time=1.0, file=str(large)))
    one = settings(small, deform=keys)
    for time, middle, radius in (
        (-1.0, 0.0, 0.45),
        (0.0, 0.0, 0.45),
        (0.5, 0.05, 0.5),
        (1.0, 0.1, 0.55),
        (2.0, 0.1, 0.55),
    ):
        solids = pack_all([one], STILL, time)
        ray = (np.float32(middle), np.float32(0), np.float32(3), *np.array([0, 0, -1], np.float32))
        assert 3 - float(rays.meet(solids, 0, *ray)) == pytest.approx(radius, abs=2e-3)
        points = np.array([[middle + radius - 0.1, 0, 0], [middle, radius + 0.01, 0]])
        # halfway distances are the mean of both files', which a shift of 2 s makes wrong by about s² / 2 r
        np.testing.assert_allclose(advice.depth(points, one, STILL, time), (0.1, -0.01), atol=5e-3)
    assert all(a is b for a, b in zip(mesh_data.data([one], 2.0), mesh_data.data([one], 3.0), strict=True))
    text = STRANDS.format(
        solver="rod", rules="gravity, collision",
        solid=f"{{kind: mesh, file: {small}, deform: [{{time: 0, file: {small}}}, {{time: 0.6, file: {large}}}]}}",
    )  # fmt: skip
    scene = loads(text, rules=registry())
    made = RodSolver(scene, emit(scene.emitter, scene.seed))
    for frame in (5, 10, 20):
        made.advance(frame)
        assert made.errors(frame)["penetration_max"] < 1e-3
    away = np.linalg.norm(made.particles()[:, 1:].reshape(-1, 3) - (0.1, 0, 0), axis=1)
    assert away.min() > 0.55 - 3e-3
    assert (away < 0.56).sum() > 20
    with pytest.raises(SceneError, match="forward in time"):
        loads(text.replace("time: 0.6", "time: 0"), rules=registry())
    other = mesh_kit.write(tmp_path / "other.obj", *mesh_kit.ball(3))
    with pytest.raises(UsageError, match="vertices"):
        pack_all([settings(small, deform=(keys[0], MeshKey(time=1.0, file=str(other))))], STILL, 0.0)
