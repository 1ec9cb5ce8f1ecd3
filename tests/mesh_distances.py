"""Time, memory and error of grids of signed distances: ``python tests/mesh_distances.py [FILE]``.

Of a head of 20,000 triangles, or of a file; the least of several runs. Errors are parts of the mesh's size: at the
nodes, and of interpolation between them, by the distance from the surface.
"""

from __future__ import annotations

import itertools
import sys
import time
from pathlib import Path

import igl
import numpy as np

import mesh_kit
from strandcli.jit import parallel, prange
from strandcli.meshes.bvh import closest, make_bvh
from strandcli.meshes.distance_grid import DistanceGrid, make_distance_grid
from strandcli.meshes.kernels.distance import distance
from strandcli.meshes.make import make_mesh
from strandcli.meshes.mesh import TriangleMesh
from strandcli.meshes.read import read_mesh

RUNS = 7
POINTS = 100_000
RESOLUTIONS = (32, 64, 128, 256)
BANDS = (0, 1, 8, 16, np.inf)
"""Distances from the surface, in cells of the grid, between which errors are told."""
WANTED = 1e-3
"""The error to hold, as a part of the mesh's size."""
NEAR = 0.05
"""How far from the surface the points for the first table are, as a part of the mesh's size."""


@parallel
def look(grid, points, found):
    for i in prange(points.shape[0]):
        found[i] = distance(grid, points[i, 0], points[i, 1], points[i, 2])


def main() -> None:
    mesh = read_mesh(Path(sys.argv[1])) if len(sys.argv) > 1 else make_mesh(*mesh_kit.head())
    begin = time.perf_counter()
    bvh = make_bvh(mesh.vertices, mesh.triangles)
    tree = time.perf_counter() - begin
    print(f"{mesh.triangles.shape[0]:,} triangles, {'closed' if mesh.closed else 'open'}; tree {tree:.3f} s")
    near = about(mesh, NEAR * mesh.size())
    closest(bvh, near[:10])
    begin = time.perf_counter()
    closest(bvh, near)
    print(f"closest points: {POINTS / (time.perf_counter() - begin):,.0f} a second")
    exact = signed(mesh, near)
    print("| nodes | seconds | of processors | MB | error at nodes | between: median | 99 % | largest | wrong side |")
    print("|" + "---|" * 9)
    for resolution in RESOLUTIONS:
        grid, seconds, processors = made(mesh, resolution)
        errors, found, true = errors_at(grid, mesh, near, exact)
        nz, ny, nx = grid.values.shape
        row = [
            f"{nx} × {ny} × {nz}", f"{seconds:.2f}", f"{processors:.2f}", f"{grid.values.nbytes / 1e6:.1f}",
            f"{error_at_nodes(grid, mesh):.0e}", f"{np.median(errors):.1e}", f"{np.quantile(errors, 0.99):.1e}",
            f"{errors.max():.1e}", f"{np.mean((found < 0) != (true < 0)):.2%}",
        ]  # fmt: skip
        print("|", " | ".join(row), "|")
    for resolution in RESOLUTIONS[-2:]:
        tell_bands(mesh, resolution)


def tell_bands(mesh: TriangleMesh, resolution: int) -> None:
    """Print the errors between nodes by the distance from the surface, of points outside and inside."""
    grid, _, _ = made(mesh, resolution, 1)
    cell = float(grid.spacing)
    points = [about(mesh, reach * cell) for reach in BANDS[1:-1]]
    low, high = mesh.box()
    points.append(np.random.default_rng(2).uniform(low, high, (POINTS, 3)))
    errors, _, true = errors_at(grid, mesh, np.concatenate(points))
    print(f"{resolution} nodes, a cell is {cell / mesh.size():.1e} of the size:")
    print(f"| side | cells from the surface | points | mean | 99 % | largest | over {WANTED:g} |")
    print("|" + "---|" * 7)
    for side, there in (("outside", true >= 0), ("inside", true < 0)):
        for least, most in itertools.pairwise(BANDS):
            some = errors[there & (np.abs(true) >= least * cell) & (np.abs(true) < most * cell)]
            if some.size < POINTS // 100:  # too few for a hundredth of them
                continue
            row = [
                side, f"{least} to {most}" if most < np.inf else f"{least} and more", f"{some.size:,}",
                f"{some.mean():.1e}", f"{np.quantile(some, 0.99):.1e}", f"{some.max():.1e}",
                f"{np.mean(some > WANTED):.3%}",
            ]  # fmt: skip
            print("|", " | ".join(row), "|")


def made(mesh: TriangleMesh, resolution: int, runs: int = RUNS) -> tuple[DistanceGrid, float, float]:
    """A grid, and the least seconds, by the clock and of processors, that making it with its tree takes."""
    times, used = [], []
    for _ in range(runs):
        begin, before = time.perf_counter(), time.process_time()
        grid = make_distance_grid(make_bvh(mesh.vertices, mesh.triangles), mesh.closed, resolution)
        times.append(time.perf_counter() - begin)
        used.append(time.process_time() - before)
    return grid, min(times), min(used)


def about(mesh: TriangleMesh, reach: float) -> np.ndarray:
    """Points (POINTS, 3) about the surface, no farther from it than `reach`."""
    generator = np.random.default_rng(1)
    picked = mesh.vertices[mesh.triangles[generator.integers(mesh.triangles.shape[0], size=POINTS)]]
    points: np.ndarray = np.einsum("pk,pkj->pj", generator.dirichlet(np.ones(3), POINTS), picked)
    return points + generator.uniform(-reach, reach, (POINTS, 3)) / np.sqrt(3)


def error_at_nodes(grid: DistanceGrid, mesh: TriangleMesh) -> float:
    """The largest error at nodes picked by chance, as a part of the mesh's size."""
    nz, ny, nx = grid.values.shape
    node = np.random.default_rng(1).integers((nx, ny, nz), size=(POINTS, 3))
    places = grid.low + grid.spacing * node
    off = grid.values[tuple(node.T[::-1])] - signed(mesh, places.astype(float))
    return float(np.abs(off).max()) / mesh.size()


def errors_at(
    grid: DistanceGrid, mesh: TriangleMesh, points: np.ndarray, exact: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of points within the grid the errors, as parts of the mesh's size, the distances by the grid and the exact
    ones."""
    exact = signed(mesh, points) if exact is None else exact
    high = grid.low + grid.spacing * (np.array(grid.values.shape[::-1]) - 1)
    within = ((points >= grid.low) & (points <= high)).all(axis=1)
    found = np.empty(points.shape[0])
    look(grid, points, found)
    return np.abs(found - exact)[within] / mesh.size(), found[within], exact[within]


def signed(mesh: TriangleMesh, points: np.ndarray) -> np.ndarray:
    """Signed distances by libigl."""
    vertices, triangles = mesh.vertices, mesh.triangles.astype(np.int64)
    squared, _, _ = igl.point_mesh_squared_distance(points, vertices, triangles)
    sides = np.empty(points.shape[0])
    for begin in range(0, points.shape[0], 10_000):
        sides[begin : begin + 10_000] = igl.fast_winding_number(vertices, triangles, points[begin : begin + 10_000])
    return np.where(sides > 0.5, -1.0, 1.0) * np.sqrt(squared)


if __name__ == "__main__":
    main()
