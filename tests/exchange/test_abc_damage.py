"""Archives of Alembic that are damaged, or hold what strands cannot."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import abc_kit
import exchange_kit as kit
from abc_kit import DATA, Builder
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
    with pytest.raises(UsageError) as error:
        read_bytes(content)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_strands_that_come_and_go_are_refused_over_time(tmp_path: Path) -> None:
    made = Builder()
    points = made.array("P", POINTS, POINTS)
    counts = made.array("nVertices", np.array(COUNTS, "<i4"), np.array([6, 6], "<i4"))
    (tmp_path / "a.abc").write_bytes(
        made.finish(made.object("c", abc_kit.CURVES, [made.compound(".geom", [points, counts])]))
    )
    assert read(tmp_path / "a.abc").count == 3
    with pytest.raises(UsageError, match="at 1 s it has other curves than at first"):
        moments(tmp_path / "a.abc")


def test_names_that_alembic_cannot_hold_are_left_out(tmp_path: Path) -> None:
    held = kit.of(STRANDS)
    wrong = {name: Attribute("strand", np.zeros((3, width), np.float32)) for name, width in (("a/b", 1), ("c", 300))}
    assert write(tmp_path / "a.abc", Strands(held.first, held.points, wrong)) == [".abc cannot store a/b, c: left out"]
