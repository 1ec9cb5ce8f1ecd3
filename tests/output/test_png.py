"""The PNG encoder: whatever is written, two independent decoders read back."""

from __future__ import annotations

import io
import struct
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image

from strandcli.output import png

images = hnp.arrays(np.uint8, st.tuples(st.integers(1, 40), st.integers(1, 40), st.just(3)))


def decode_by_hand(data: bytes) -> tuple[np.ndarray, list[bytes]]:
    """A reader of its own for truecolour files, which checks every CRC."""
    assert data.startswith(b"\x89PNG\r\n\x1a\n")
    at, kinds, packed, width, height = 8, [], b"", 0, 0
    while at < len(data):
        (length,) = struct.unpack_from(">I", data, at)
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        (check,) = struct.unpack_from(">I", data, at + 8 + length)
        assert check == zlib.crc32(kind + body)
        kinds.append(kind)
        if kind == b"IHDR":
            width, height, *rest = struct.unpack(">IIBBBBB", body)
            assert rest == [8, 2, 0, 0, 0]
        if kind == b"IDAT":
            packed += body
        at += 12 + length
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + 3 * width)
    assert (rows[:, 0] == 1).all(), "each row: differences from the pixel to the left"
    return np.add.accumulate(rows[:, 1:].reshape(height, width, 3), axis=1, dtype=np.uint8), kinds


@given(images)
def test_two_decoders_read_back_what_was_encoded(image: np.ndarray) -> None:
    data = b"".join(png.encode(image, {"Comment": "grüße"}))
    by_hand, kinds = decode_by_hand(data)
    np.testing.assert_array_equal(by_hand, image)
    assert kinds[0] == b"IHDR"
    assert kinds[-1] == b"IEND"
    with Image.open(io.BytesIO(data)) as decoded:
        assert decoded.mode == "RGB"
        np.testing.assert_array_equal(np.asarray(decoded), image)
        assert decoded.info["Comment"] == "grüße"


def test_a_picture_of_several_chunks_is_whole() -> None:
    image = np.random.default_rng(3).integers(0, 256, (700, 900, 3), dtype=np.uint8)
    by_hand, kinds = decode_by_hand(b"".join(png.encode(image)))
    assert kinds.count(b"IDAT") > 1
    np.testing.assert_array_equal(by_hand, image)


def test_an_image_that_is_no_array_of_its_own_is_encoded_as_seen() -> None:
    image = np.random.default_rng(4).integers(0, 256, (9, 12, 3), dtype=np.uint8)[::-1, ::2]
    np.testing.assert_array_equal(decode_by_hand(b"".join(png.encode(image)))[0], image)
    assert png.pixels_sha256(image) == png.pixels_sha256(image.copy())


@given(images, st.data())
def test_the_hash_changes_with_any_pixel_and_with_the_shape(image: np.ndarray, data: st.DataObject) -> None:
    at = tuple(data.draw(st.integers(0, n - 1)) for n in image.shape)
    changed = image.copy()
    changed[at] ^= 1
    assert png.pixels_sha256(changed) != png.pixels_sha256(image)
    if image.shape[0] != image.shape[1]:
        turned = image.reshape(image.shape[1], image.shape[0], 3)
        assert png.pixels_sha256(turned) != png.pixels_sha256(image)


@pytest.mark.parametrize(("shape", "kind"), [((2,), "u1"), ((2, 2, 3), "f4"), ((0, 2, 3), "u1"), ((2, 2, 2), "u1")])
def test_only_pictures_are_encoded(shape: tuple[int, ...], kind: str) -> None:
    with pytest.raises(ValueError, match="a frame must be uint8"):
        png.encode(np.zeros(shape, kind))
