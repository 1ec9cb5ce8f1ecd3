"""Curves of Alembic archives (https://www.alembic.io), Ogawa back end.

The layout was learnt from the source of Alembic 1.8 (https://github.com/alembic/alembic: Ogawa, AbcCoreOgawa, AbcGeom),
and checked with files that Blender wrote.
"""
