"""Transforms in Alembic's archives, by their closed forms."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import abc_kit
from abc_kit import EVERY_SECOND, Builder
from strandcli.exchange.files import read
from tests.exchange.test_abc import COUNTS, POINTS, moments, read_bytes


def rows(*lines: Sequence[float]) -> Any:
    return np.array(lines, float)


TRANSFORMS = [
    ([1], [2, 3, 5], rows([1, 0, 0], [0, 1, 0], [0, 0, 1], [2, 3, 5])),
    ([0], [2, 3, 5], rows([2, 0, 0], [0, 3, 0], [0, 0, 5], [0, 0, 0])),
    ([6], [90], rows([0, 1, 0], [-1, 0, 0], [0, 0, 1], [0, 0, 0])),
    ([2], [1, 1, 1, 120], rows([0, 1, 0], [0, 0, 1], [1, 0, 0], [0, 0, 0])),
    ([3], range(16), rows([0, 1, 2], [4, 5, 6], [8, 9, 10], [12, 13, 14])),
    # what is told last is done first: scaled, then turned, then moved
    ([1, 6, 0], [1, 0, 0, 90, 2, 2, 2], rows([0, 2, 0], [-2, 0, 0], [0, 0, 2], [1, 0, 0])),
]


@pytest.mark.parametrize(("codes", "values", "matrix"), TRANSFORMS)
def test_points_are_where_transforms_put_them(codes: list[int], values: Any, matrix: Any) -> None:
    made = Builder()
    width = made.array("width", np.ones(12, "<f4"))
    content = made.finish(made.xform("a", codes, [values], [made.curves("b", POINTS, COUNTS, [width])]))
    found = read_bytes(content)
    np.testing.assert_allclose(found.points, POINTS @ matrix[:3] + matrix[3], rtol=1e-6, atol=1e-4)
    scale = np.cbrt(abs(np.linalg.det(matrix[:3])))
    np.testing.assert_allclose(found.attributes["width"].values, scale, rtol=1e-6, atol=1e-4)


def test_normals_turn_as_planes_do() -> None:
    """A normal of a plane stays one: at right angles to what was in the plane."""
    made = Builder()
    matrix = np.array([[-4.0, 1, 0, 0], [0, 1, 3, 0], [1, 0, 1, 0], [5, 5, 5, 1]])
    along = np.random.default_rng(1).normal(size=(12, 3))
    normals = np.cross(along, [1.0, 2.0, 3.0]).astype("<f4")
    told = made.array("N", normals, meta="geoScope=vtx")
    curves = made.curves("b", POINTS, COUNTS, [told])
    found = read_bytes(made.finish(made.xform("a", [3], [matrix.reshape(-1)], [curves])))
    turned = found.attributes["normal"].values
    np.testing.assert_allclose(np.einsum("ij,ij->i", turned, along @ matrix[:3, :3]), 0, atol=2e-5)
    np.testing.assert_allclose(np.linalg.norm(turned, axis=1), np.linalg.norm(normals, axis=1), rtol=1e-6)
    inverse = normals @ np.linalg.inv(matrix[:3, :3]).T
    assert (np.einsum("ij,ij->i", turned, inverse) > 0).all()


def test_a_transform_may_leave_those_that_hold_it() -> None:
    made = Builder()
    inner = made.xform("b", [1], [[1, 0, 0]], [made.curves("c", POINTS, COUNTS)], inherits=False)
    assert read_bytes(made.finish(made.xform("a", [1], [[0, 9, 0]], [inner]))).points.tolist() == (
        (POINTS + np.float32([1, 0, 0])).tolist()
    )


def test_transforms_and_points_that_move_are_seen_at_all_their_times(tmp_path: Path) -> None:
    made = Builder()
    samplings = EVERY_SECOND + struct.pack("<IdId", 2, 0.5, 1, 1.0)
    still = made.curves("b", POINTS, COUNTS)
    moving = made.xform("a", [1], [[0, 0, 0], [0, 7, 0]], [still], sampling=1)
    points = made.array("P", POINTS, POINTS + np.float32(1), POINTS + np.float32(2))
    told = [points, made.array("nVertices", np.array(COUNTS, "<i4"))]
    content = made.finish(moving, made.object("c", abc_kit.CURVES, [made.compound(".geom", told)]), samplings=samplings)
    (tmp_path / "a.abc").write_bytes(content)
    found = {one.seconds: one.points for one in moments(tmp_path / "a.abc")}
    assert list(found) == [0.0, 1.0, 1.5, 2.0]
    for seconds, (up, step) in {0.0: (0, 0), 1.0: (0, 1), 1.5: (7, 1), 2.0: (7, 2)}.items():
        assert found[seconds][:12].tolist() == (POINTS + np.float32([0, up, 0])).tolist()
        assert found[seconds][12:].tolist() == (POINTS + np.float32(step)).tolist()
    assert read(tmp_path / "a.abc").source.facts["times"] == 4
