"""Meshes of a scene's solids, from files: read, placed in the solid's frame, and packed for kernels.

`read` places a file's mesh, `prepared` adds what rays and contact need (tree, distances, colours) and puts those of all
such solids together, and `kernels.shape` has the functions that read them. `strandcli.solid_shapes.mesh` is the shape's
file, which imports this room when a mesh is drawn or touched.
"""
