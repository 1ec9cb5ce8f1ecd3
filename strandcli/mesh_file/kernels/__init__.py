"""Compiled functions of solids that are meshes."""
