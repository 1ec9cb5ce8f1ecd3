"""Triangle meshes: read (`read.read_mesh`), mended (`make.make_mesh`), and asked where rays meet them, which point is
nearest and how far they are (`bvh.make_bvh`, `bvh.make_distance_grid`; in kernels `kernels.rays.first_hit`,
`kernels.nearest.nearest`, `kernels.winding.winding`, `kernels.distance.distance_and_gradient`).
"""

SUFFIXES = (".obj", ".ply", ".stl", ".glb", ".gltf")
"""Ends of names of files that hold meshes, or strands as lines but for .stl."""
