"""Compiled code of meshes."""
