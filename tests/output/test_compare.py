"""Comparison of images against the definitions, worked by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image

from strandcli.errors import UsageError
from strandcli.output import png
from strandcli.output.compare import compare, compare_files, difference_image, side_by_side

pairs = st.tuples(st.integers(1, 9), st.integers(1, 9)).flatmap(
    lambda size: st.tuples(*[hnp.arrays(np.uint8, (*size, 3))] * 2)
)


@given(pairs, st.integers(0, 255))
def test_the_numbers_are_those_of_the_definitions(pair: tuple[np.ndarray, np.ndarray], threshold: int) -> None:
    a, b = (image.tolist() for image in pair)
    differences = [
        [[abs(x - y) for x, y in zip(p, q, strict=True)] for p, q in zip(r, s, strict=True)]
        for r, s in zip(a, b, strict=True)
    ]
    worst = [max(pixel) for row in differences for pixel in row]
    squares = [d * d for row in differences for pixel in row for d in pixel]
    found = compare(*pair, threshold)
    assert found.over == sum(d > threshold for d in worst)
    assert found.over_fraction == pytest.approx(found.over / len(worst))
    assert found.max_difference == max(worst)
    mean = sum(squares) / len(squares)
    assert found.rmse == pytest.approx(math.sqrt(mean))
    assert found.equal == (not any(squares))
    if mean:
        assert found.psnr_db == pytest.approx(20 * math.log10(255 / math.sqrt(mean)))
    else:
        assert found.psnr_db is None


def test_alpha_counts_where_there_is_some(tmp_path: Path) -> None:
    Image.new("RGB", (2, 2), (9, 9, 9)).save(tmp_path / "a.png")
    Image.new("RGBA", (2, 2), (9, 9, 9, 255)).save(tmp_path / "b.png")
    Image.new("RGBA", (2, 2), (9, 9, 9, 254)).save(tmp_path / "c.png")
    assert compare_files(tmp_path / "a.png", tmp_path / "b.png")[0].equal
    assert compare_files(tmp_path / "a.png", tmp_path / "c.png")[0].max_difference == 1


def test_a_single_pixel_is_seen_in_the_difference_image() -> None:
    a = np.full((20, 30, 3), 80, np.uint8)
    b = a.copy()
    b[7, 11, 1] += 1
    picture = difference_image(a, b)
    assert picture.shape == a.shape
    coloured = np.argwhere((picture != picture[0, 0]).any(axis=2))
    assert {tuple(at) for at in coloured} == {(y, x) for y in (6, 7, 8) for x in (10, 11, 12)}
    assert (picture[7, 11] == 255).all()
    wide = side_by_side(a, b)
    assert wide.shape == (20, 94, 3)
    np.testing.assert_array_equal(wide[:, 32:62], b)


@pytest.mark.parametrize("grey", [True, False])
def test_sixteen_bits_are_compared_in_full(tmp_path: Path, grey: bool) -> None:
    a = np.full((4, 6) if grey else (4, 6, 3), 2000, np.uint16)
    b = a.copy()
    b[1, 2] += 1
    for name, image in (("a.png", a), ("b.png", b)):
        (tmp_path / name).write_bytes(b"".join(png.encode(image)))
    found, one, two, _ = compare_files(tmp_path / "a.png", tmp_path / "b.png")
    assert (found.over, found.max_difference) == (1, pytest.approx(1 / 257))
    np.testing.assert_allclose(one, 2000 / 257)
    assert compare_files(tmp_path / "a.png", tmp_path / "a.png")[0].equal
    assert difference_image(one, two).dtype == np.uint8
    Image.new("RGB", (6, 4), (8, 8, 8)).save(tmp_path / "eight.png")
    assert compare_files(tmp_path / "a.png", tmp_path / "eight.png")[0].max_difference == pytest.approx(8 - 2000 / 257)


def test_samples_of_32_bits_are_refused(tmp_path: Path) -> None:
    Image.fromarray(np.full((4, 6), 0.5, np.float32)).save(tmp_path / "a.tif")
    with pytest.raises(UsageError, match=r"a\.tif: .*32 bits; save it with 8 or 16, as PNG"):
        compare_files(tmp_path / "a.tif", tmp_path / "a.tif")
