"""Strands with the colours of the mesh that they grow on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mesh_kit import ply, sphere
from strandcli.draw.lighting.palette import Palette
from strandcli.errors import UsageError
from strandcli.groom.emit import emit
from strandcli.groom.on_mesh import SHADES
from strandcli.groom.record import Groom
from strandcli.meshes.mesh import TriangleMesh
from strandcli.scene.model import Emitter, Material, MeshShape

COUNT = 4000


def ball(path: Path, colours: bool = True) -> str:
    """A ball whose red grows with x and whose green with y, in light; its blue is 0.3."""
    vertices, triangles = sphere()
    light = np.column_stack([0.5 + 0.5 * vertices[:, :2], np.full(len(vertices), 0.3)])
    codes = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    more = dict(zip(("red", "green", "blue"), codes.T.astype("f4"), strict=True)) if colours else None
    path.write_bytes(ply(TriangleMesh(vertices, triangles.astype(np.int32), vertices), more=more))
    return str(path)


def grown(file: str, count: int = COUNT, colours: str = "file") -> Groom:
    return emit(Emitter(shape=MeshShape(file=file, colours=colours), strands=COUNT), 3, count)


def rows_of(groom: Groom) -> np.ndarray:
    """Of each strand the row of the table of shades of colours."""
    assert groom.colours is not None
    found = (groom.tones + 1) / 2 * (len(groom.colours) * groom.shades - 1)
    np.testing.assert_allclose(found, np.rint(found), atol=1e-3)
    return np.rint(found).astype(int)


def test_strands_have_the_colour_at_their_roots(tmp_path: Path) -> None:
    groom = grown(ball(tmp_path / "ball.ply"))
    light = groom.colours[rows_of(groom) // groom.shades]
    wanted = np.column_stack([0.5 + 0.5 * groom.roots[:, :2], np.full(COUNT, 0.3)])
    away = np.abs(light - wanted).max(axis=1)
    assert np.quantile(away, 0.9) < 0.09, "a palette of 96 colours"
    assert away.max() < 0.2


def test_the_first_strands_do_not_depend_on_how_many_there_are(tmp_path: Path) -> None:
    file = ball(tmp_path / "ball.ply")
    all_of_them, first = grown(file), grown(file, 100)
    np.testing.assert_array_equal(first.tones, all_of_them.tones[:100])
    np.testing.assert_array_equal(first.colours, all_of_them.colours)


def test_shades_are_as_frequent_and_do_not_depend_on_the_place(tmp_path: Path) -> None:
    groom = grown(ball(tmp_path / "ball.ply"))
    shades = rows_of(groom) % groom.shades
    assert groom.shades == SHADES
    assert np.bincount(shades).min() > 0.9 * COUNT / SHADES
    assert abs(np.corrcoef(shades, groom.roots[:, 0])[0, 1]) < 0.05


def test_a_mesh_without_colours_is_told(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="neither vertex colours nor a texture"):
        grown(ball(tmp_path / "plain.ply", colours=False))


def test_colours_vary_as_the_material_does() -> None:
    colours = np.array([[0.2, 0.1, 0.05], [0.9, 0.8, 0.7]], np.float32)
    material = Material(model="chiang", colour=(0.4, 0.4, 0.4), tip_colour=(0.2, 0.4, 0.4), colour_variation=0.5)
    table = Palette(material, False, colours, 2).tint
    first = table[0, :, :3]
    np.testing.assert_allclose(first[1] / first[0], 1.5, rtol=1e-5)  # the shades -1/2 and 1/2 of 1.5 to that power
    np.testing.assert_allclose(first[:2].prod(axis=0), colours[0] ** 2, rtol=1e-5)
    np.testing.assert_allclose(table[-1, 0, :3], first[0] * (0.5, 1, 1), rtol=1e-5)
    assert first.max() <= 0.92 + 1e-6
    np.testing.assert_allclose(first[3] / first[3, 0], colours[1] / colours[1, 0], rtol=1e-5)
