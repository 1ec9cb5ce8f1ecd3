"""Shapes of solids without compiled code: columns of the packed row, bounding ball, depth of points. One file for each
shape; its kernels are in the file of the same name in `strandcli.solids.kernels`."""
