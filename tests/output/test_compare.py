"""Comparison of images against the definitions: differences worked by hand, and ꟻLIP against closed forms."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image

from cli_runs import Runner
from strandcli.errors import UsageError
from strandcli.output import flip as module
from strandcli.output import png
from strandcli.output.compare import compare, compare_files, difference_image, side_by_side, write_image
from strandcli.output.flip import flip

pairs = st.tuples(st.integers(1, 12), st.integers(1, 12)).flatmap(
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


def even(*colour: int, size: tuple[int, int] = (4, 6)) -> np.ndarray:
    return np.full((*size, 3), colour, np.uint8)


def lightness(level: int) -> float:
    """L* of a grey of 8 bits, by CIE 15 and IEC 61966-2-1."""
    s = level / 255
    y = ((s + 0.055) / 1.055) ** 2.4 if s > 0.04045 else s / 12.92
    return 116 * y ** (1 / 3) - 16 if y > (6 / 29) ** 3 else y * (29 / 3) ** 3


@settings(deadline=None, max_examples=30)
@given(pairs)
def test_it_is_symmetric_within_bounds_and_zero_for_the_same(pair: tuple[np.ndarray, np.ndarray]) -> None:
    found = flip(*pair)
    assert found.shape == pair[0].shape[:2]
    assert (found >= 0).all()
    assert (found <= 1).all()
    np.testing.assert_array_equal(found, flip(pair[1], pair[0]))
    assert not flip(pair[0], pair[0]).any()


def test_even_greys_differ_by_their_lightness() -> None:
    """Filters leave even pictures as they are and find no feature in them, so that the difference is that of lightness
    to the power .7, on a range of which the greatest, green against blue, is 41.2761."""
    knee = 0.4 * 41.2761
    for a, b in ((0, 255), (0, 10), (100, 140), (30, 200)):
        apart = abs(lightness(a) - lightness(b)) ** 0.7
        expected = 0.95 * apart / knee if apart < knee else 0.95 + 0.05 * (apart - knee) / (41.2761 - knee)
        np.testing.assert_allclose(flip(even(a, a, a), even(b, b, b)), expected, atol=2e-5)


def test_filters_are_those_of_two_dimensions() -> None:
    """The separable filters beside the paper's, made in two dimensions, at a place that no side is near."""
    rng = np.random.default_rng(3)
    density, size = 20.0, 25
    picture = rng.random((size, size, 3))
    found = module._blurred(picture, density)[size // 2, size // 2]
    r = math.ceil(3 * math.sqrt(0.04 / (2 * math.pi**2)) * density)
    y, x = np.mgrid[-r : r + 1, -r : r + 1] / density
    part = picture[size // 2 - r : size // 2 + r + 1, size // 2 - r : size // 2 + r + 1]
    for channel, parts in enumerate((((1, 0.0047),), ((1, 0.0053),), ((34.1, 0.04), (13.5, 0.025)))):
        kernel = sum(a * math.sqrt(math.pi / b) * np.exp(-(math.pi**2) * (x**2 + y**2) / b) for a, b in parts)
        assert found[channel] == pytest.approx((part[..., channel] * kernel).sum() / kernel.sum(), rel=1e-12)


def test_compare_tells_it_where_asked(tmp_path: Path, run: Runner) -> None:
    one, two = tmp_path / "a.png", tmp_path / "b.png"
    write_image(one, even(0, 0, 0))
    write_image(two, even(255, 255, 255))
    assert "ꟻLIP 0.96" in run.fine("compare", str(one), str(two), "--flip", "--allow", "100").out
    told = json.loads(run("compare", str(one), str(one), "--flip", "--json").out)
    assert told["flip"] == 0
    assert "flip" not in json.loads(run("compare", str(one), str(one), "--json").out)
