"""Triangle meshes: read, mended, and asked where rays meet them, which point is nearest, how far they are.

    from strandcli.meshes.read import read_mesh
    from strandcli.meshes.bvh import make_bvh, moved
    from strandcli.meshes.bvh import closest
    from strandcli.meshes.distance_grid import make_distance_grid

    mesh = read_mesh(path)                       TriangleMesh: vertices, triangles, normals, uv, colours, attributes
    mesh = read_mesh(path, like=mesh)            a later mesh of a sequence: the same triangles, other places
    mesh = make_mesh(vertices, triangles)        from arrays (`strandcli.meshes.make`)
    mesh = mesh.transformed(linear, shift)       scale, up axis and pose are the caller's
    bvh = make_bvh(mesh.vertices, mesh.triangles)
    bvh = moved(bvh, vertices, mesh.triangles)   the same tree about moved vertices
    points, triangles, barycentrics, distances = closest(bvh, points)
    grid = make_distance_grid(bvh, mesh.closed, 128)

In kernels, with `bvh` (`kernels.tree.Bvh`) and `grid` (`kernels.distance.DistanceGrid`), which are flat NamedTuples:

    t, triangle, u, v = rays.first_hit(bvh, ox, oy, oz, dx, dy, dz, t_max)
    rays.any_hit(bvh, ox, oy, oz, dx, dy, dz, t_max)
    squared, triangle, u, v, row = nearest.nearest(bvh, x, y, z, limit)
    winding.winding(bvh, x, y, z)                1 inside, 0 outside
    distance.distance(grid, x, y, z)             negative inside
    d, gx, gy, gz = distance.distance_and_gradient(grid, x, y, z)
"""

SUFFIXES = (".obj", ".ply", ".stl", ".glb", ".gltf")
"""Ends of names of files that hold meshes, or strands as lines but for .stl."""
