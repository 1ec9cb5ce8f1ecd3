"""Time, memory and error of grids of signed distances: ``python tests/mesh_distances.py [FILE]``.

Of a head of 20,000 triangles, or of a file; the least of several runs. Errors are parts of the mesh's size: at the
nodes, and of interpolation between them at points within a twentieth of the size from the surface.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import igl
import numpy as np

import mesh_kit
from strandcli.jit import parallel, prange
from strandcli.meshes.bvh import make_bvh
from strandcli.meshes.closest import closest
from strandcli.meshes.distance_grid import make_distance_grid
from strandcli.meshes.kernels.distance import distance
from strandcli.meshes.make import make_mesh
from strandcli.meshes.read import read_mesh

RUNS = 7
POINTS = 100_000


@parallel
def look(grid, points, found):
    for i in prange(points.shape[0]):
        found[i] = distance(grid, points[i, 0], points[i, 1], points[i, 2])


def main() -> None:
    mesh = read_mesh(Path(sys.argv[1])) if len(sys.argv) > 1 else make_mesh(*mesh_kit.head())
    size, triangles = mesh.size(), mesh.triangles.astype(np.int64)
    generator = np.random.default_rng(1)
    picked = mesh.vertices[mesh.triangles[generator.integers(triangles.shape[0], size=POINTS)]]
    near = np.einsum("pk,pkj->pj", generator.dirichlet(np.ones(3), POINTS), picked)
    near += generator.uniform(-0.05, 0.05, (POINTS, 3)) * size / np.sqrt(3)
    exact = signed(mesh.vertices, triangles, near)
    begin = time.perf_counter()
    bvh = make_bvh(mesh.vertices, mesh.triangles)
    tree = time.perf_counter() - begin
    print(f"{triangles.shape[0]:,} triangles, {'closed' if mesh.closed else 'open'}; tree {tree:.3f} s")
    closest(bvh, near[:10])
    begin = time.perf_counter()
    closest(bvh, near)
    print(f"closest points: {POINTS / (time.perf_counter() - begin):,.0f} a second")
    print("| nodes | seconds | of processors | MB | error at nodes | between: median | 99 % | largest | wrong side |")
    for resolution in (32, 64, 128, 256):
        times, used = [], []
        for _ in range(RUNS):
            begin, before = time.perf_counter(), time.process_time()
            grid = make_distance_grid(make_bvh(mesh.vertices, mesh.triangles), mesh.closed, resolution)
            times.append(time.perf_counter() - begin)
            used.append(time.process_time() - before)
        nz, ny, nx = grid.values.shape
        node = generator.integers((nx, ny, nz), size=(POINTS, 3))
        places = grid.low + grid.spacing * node
        off = np.abs(grid.values[tuple(node.T[::-1])] - signed(mesh.vertices, triangles, places.astype(float)))
        high = grid.low + grid.spacing * (np.array((nx, ny, nz)) - 1)
        within = ((near >= grid.low) & (near <= high)).all(axis=1)
        found = np.empty(POINTS)
        look(grid, near, found)
        errors = (np.abs(found - exact) / size)[within]
        wrong = np.mean((found < 0) != (exact < 0))
        row = [
            f"{nx} × {ny} × {nz}", f"{min(times):.2f}", f"{min(used):.2f}", f"{grid.values.nbytes / 1e6:.1f}",
            f"{off.max() / size:.0e}", f"{np.median(errors):.1e}", f"{np.quantile(errors, 0.99):.1e}",
            f"{errors.max():.1e}", f"{wrong:.2%}",
        ]  # fmt: skip
        print("|", " | ".join(row), "|")


def signed(vertices: np.ndarray, triangles: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Signed distances by libigl."""
    squared, _, _ = igl.point_mesh_squared_distance(points, vertices, triangles)
    sides = np.empty(points.shape[0])
    for begin in range(0, points.shape[0], 10_000):
        sides[begin : begin + 10_000] = igl.fast_winding_number(vertices, triangles, points[begin : begin + 10_000])
    return np.where(sides > 0.5, -1.0, 1.0) * np.sqrt(squared)


if __name__ == "__main__":
    main()
