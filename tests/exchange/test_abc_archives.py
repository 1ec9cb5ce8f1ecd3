"""Alembic's archives that are damaged or hold what strands cannot, and transforms in them by their closed forms."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import abc_kit
import exchange_kit as kit
from abc_kit import DATA, EVERY_SECOND, Builder
from strandcli.errors import UsageError
from strandcli.exchange.files import read, write
from strandcli.exchange.strands import Attribute, Strands
from tests.exchange.test_abc import COUNTS, POINTS, STRANDS, moments, read_bytes


def with_word(content: bytes, at: int, word: int) -> bytes:
    return content[:at] + struct.pack("<Q", word) + content[at + 8 :]


WHOLE = abc_kit.archive(STRANDS)
NOT_FINITE = np.where(POINTS == 5, np.nan, POINTS).astype("<f4")


def circle() -> bytes:
    """An object that holds itself."""
    made = Builder()
    content = made.finish(made.object("a", "", (), [made.object("b", "")]))
    holder = content.rindex(struct.pack("<Q", 3))  # the group of a: properties, b, headers
    inner = struct.unpack_from("<Q", content, holder + 16)[0]
    return with_word(content, holder + 16, holder) if inner < DATA else content


def tower() -> bytes:
    """Objects in one another."""
    made = Builder()
    one = made.object("a", "")
    for _ in range(200):
        one = made.object("a", "", (), [one])
    return made.finish(one)


def shared() -> bytes:
    """Many objects whose points are the same megabyte."""
    made = Builder()
    header, word = made.curves("a", np.zeros((100_000, 3), "<f4"), [100_000])
    copies = []
    for number in range(100):
        name = f"{number:02}".encode()
        geometry = struct.unpack_from("<3Q", made.content, word)
        group = made.group(*geometry[1:])
        copies.append((struct.pack("<I", 2) + name + header[5:], group))
    return made.finish(*copies)


def curves(points: Any, counts: Any, *basis: Any) -> bytes:
    made = Builder()
    more = [made.array("curveBasisAndType", one, scalar=True) for one in basis]
    return made.finish(made.curves("a", points, counts, more))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (WHOLE[:10], "byte 0: header: needs 16 bytes, the file has 10 bytes there"),
        (b"Ogawa\0" + WHOLE[6:], "byte 5: header: the program that wrote it did not finish"),
        (b"\x89HDF\r\n\x1a\n" + bytes(60), "HDF5 back end; convert it with abcconvert -toOgawa"),
        (with_word(WHOLE, 8, 1 << 50), "byte 8: archive: begins at byte 1,125,899,906,842,624, the file has"),
        (with_word(WHOLE, 16, 1 << 40), "byte 16: /hair/.geom/P: 1,099,511,627,776 need 1.1 TB, the file has"),
        (with_word(WHOLE, 16, 16 + 143), "byte 24: /hair/.geom/P: 143 bytes are no whole number of 12 bytes each"),
        (with_word(WHOLE, 16, 16 + 132), "/hair: 11 points, the curves have 12"),
        (curves(POINTS, [4, 9, -1]), "/a/.geom/nVertices: curve 2 has -1 points"),
        (curves(POINTS[:, :2], COUNTS), "/a/.geom/P: 2 float32_t an element"),
        (curves(NOT_FINITE, COUNTS), "byte 52: /a/.geom/P: number 1 is not finite"),
        (Builder().finish(), "has no curves"),
        (circle(), "is referenced twice, or by itself"),
        (tower(), "is referenced by 128 objects in one another"),
        (shared(), "parts that are shared make more than is believed of a file of"),
        (curves(POINTS, COUNTS, np.ones((2, 4), "u1")), "/a/.geom/curveBasisAndType: 2 values of a scalar"),
    ],
)  # fmt: skip
def test_bad_archives_are_refused_by_field_and_byte(content: bytes, message: str) -> None:
    kit.refused(content, ".abc", message)


def test_strands_that_come_and_go_are_refused_over_time(tmp_path: Path) -> None:
    made = Builder()
    points = made.array("P", POINTS, POINTS)
    counts = made.array("nVertices", np.array(COUNTS, "<i4"), np.array([6, 6], "<i4"))
    (tmp_path / "a.abc").write_bytes(
        made.finish(made.object("c", abc_kit.CURVES, [made.compound(".geom", [points, counts])]))
    )
    assert read(tmp_path / "a.abc").count == 3
    with pytest.raises(UsageError, match="at 1 s: has other strands than before"):
        moments(tmp_path / "a.abc")


def test_names_that_alembic_cannot_hold_are_left_out(tmp_path: Path) -> None:
    held = kit.of(STRANDS)
    wrong = {name: Attribute("strand", np.zeros((3, width), np.float32)) for name, width in (("a/b", 1), ("c", 300))}
    assert write(tmp_path / "a.abc", Strands(held.first, held.points, wrong)) == [".abc cannot store a/b, c: left out"]


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
