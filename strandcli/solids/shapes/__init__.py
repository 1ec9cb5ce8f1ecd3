"""What each shape of solid is without compiled code: its packed row, whose columns have names, the ball about it, and
the depth of points in it. One file a shape; kernels of the same name are in `strandcli.solids.kernels`."""
