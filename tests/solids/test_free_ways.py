"""Tables of how far light comes freely past a mesh: strands see as much of lights with them as without."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import mesh_kit
from strandcli.constants import W
from strandcli.draw.common.kernels import batch, surface_batch
from strandcli.draw.common.kernels.light_columns import COLUMNS, KIND, LIGHT_SIZE, PLACE_X
from strandcli.draw.lighting.lighting import NO_FREE_WAYS, free_ways
from strandcli.draw.shadows.kernels.free_ways import FreeWays
from strandcli.draw.shadows.kernels.soft_shadows import soft_shadows
from strandcli.scene.model import Emitter, SphereSolid
from strandcli.solid_shapes.mesh import Settings
from strandcli.solids import Solids, pack_all

SKIN = np.float32(4e-3)
BOUNDS = np.array([[-1.5, -1.0, -1.0], [1.0, 1.5, 1.0]])
POINTS = 40 * W


@pytest.fixture(scope="module")
def solids(tmp_path_factory: pytest.TempPathFactory) -> Solids:
    """Two balls, one before the other in some of the lights."""
    path = mesh_kit.write(tmp_path_factory.mktemp("balls") / "ball.obj", *mesh_kit.ball(4, 0.4))
    balls = [Settings(file=str(path), position=at) for at in ((0.1, 0, 0), (-0.9, 0.3, 0.2))]
    return pack_all(balls, Emitter(), 0.0)


def light(way: tuple[float, float, float], size: float) -> NDArray[np.float32]:
    row = np.zeros(COLUMNS, np.float32)
    row[PLACE_X : PLACE_X + 3] = np.array(way) / np.linalg.norm(way)
    row[LIGHT_SIZE] = size
    return row


def rows_of(points: NDArray[np.float64], row: NDArray[np.float32]) -> NDArray[np.float32]:
    """A batch of points in a light."""
    work = np.zeros((surface_batch.ROWS, W), np.float32)
    work[batch.X // W : batch.X // W + 3] = points.T
    work[batch.LX // W : batch.LX // W + 3] = row[PLACE_X : PLACE_X + 3, None]
    work[batch.REACH // W], work[batch.ARRIVES // W] = 1e30, 1
    return work.reshape(-1)


@pytest.mark.parametrize(("way", "size"), [((1, 0.2, 0.1), 0.07), ((-0.3, 0.9, -0.5), 0.2), ((0.2, -0.1, 1), 0.0)])
def test_as_much_of_a_light_is_seen_with_tables(solids: Solids, way: tuple[float, float, float], size: float) -> None:
    """Inside of the balls and outside of the tables, too. A second light has a size in any case."""
    lights = np.stack([light(way, size), light((0, 1, 0), 0.1)])
    free = free_ways(lights, solids, SKIN, BOUNDS)
    points = np.random.default_rng(3).uniform(-1.2, 1.2, (POINTS, 3))
    off, whole = [], 0
    for some in points.reshape(-1, W, 3):
        with_tables, without = rows_of(some, lights[0]), rows_of(some, lights[0])
        soft_shadows(with_tables, W, lights, 0, solids, SKIN, free)
        soft_shadows(without, W, lights, 0, solids, SKIN, NO_FREE_WAYS)
        here = slice(batch.ARRIVES, batch.ARRIVES + W)
        off.append(np.abs(with_tables[here] - without[here]))
        whole += int((without[here] == 1).sum())
    assert np.max(off) < 0.02
    assert np.mean(off) < 1e-5
    assert 0.5 < whole / POINTS < 0.98


def test_without_vectors_a_size_or_parallel_rays_there_are_no_tables(solids: Solids) -> None:
    sized, sharp, point = light((0, 1, 0), 0.1), light((0, 1, 0), 0.0), light((0, 1, 0), 0.1)
    point[KIND] = 1
    sphere = pack_all([SphereSolid(radius=0.5)], Emitter(), 0.0)
    assert len(free_ways(np.stack([sized, sharp]), solids, SKIN, BOUNDS).depths) == 2
    for rows, among in (((sharp,), solids), ((sized, point), solids), ((sized,), sphere), ((sized,), None)):
        found = free_ways(np.stack(rows), among, SKIN, BOUNDS)
        assert isinstance(found, FreeWays)
        assert not len(found.depths)
