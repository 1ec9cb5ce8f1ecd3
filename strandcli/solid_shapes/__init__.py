"""Shapes of solids, a file each, named by the kind that presets write: all that is known of a shape stands in it.

A file has the names that `strandcli.scene.model.solids.SolidShape` describes. It is found by being here. Files import
neither NumPy nor Numba: they are read with a preset, and compiled when such a solid is drawn or touched.
"""
