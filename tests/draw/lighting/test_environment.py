"""Light from a lat-long picture: harmonics against quadrature, files, and refusals."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from strand_kit import frames_of
from strandcli import load
from strandcli.draw.lighting.environment import coefficients, read, read_hdr, sky_of
from strandcli.draw.lighting.kernels import light
from strandcli.errors import UsageError
from strandcli.jit import function
from strandcli.output import png
from strandcli.scene import SceneError

HIGH, WIDE = 48, 96


@function
def around(sky: Any, which: Any, c: Any, x: Any, y: Any, z: Any) -> Any:
    """`light.around`, which is part of its callers."""
    return light.around(sky, which, c, x, y, z)


def sphere() -> tuple[np.ndarray, np.ndarray]:
    """Directions (HIGH, WIDE, 3) of a lat-long picture, and each pixel's share of the sphere."""
    polar, turn = np.meshgrid(
        (np.arange(HIGH) + 0.5) * np.pi / HIGH, (np.arange(WIDE) + 0.5) * 2 * np.pi / WIDE, indexing="ij"
    )
    ways = np.stack([np.sin(polar) * np.sin(turn), np.cos(polar), -np.sin(polar) * np.cos(turn)], -1)
    return ways, np.sin(polar) * (np.pi / HIGH) * (2 * np.pi / WIDE)


def picture() -> np.ndarray:
    """Smooth: a bright sky from one side, brown earth."""
    ways, _ = sphere()
    lobe = np.exp(1.2 * (ways @ np.array([0.6, 0.7, 0.39]) - 1))
    return lobe[..., None] * [1.0, 0.9, 0.8] + 0.1 * (1 - ways[..., 1:2]) * [0.3, 0.2, 0.1]


@pytest.mark.parametrize("which", [0, 1], ids=["strand", "surface"])
def test_nine_terms_are_the_integral_over_the_sphere(which: int) -> None:
    ways, area = sphere()
    sky = coefficients(picture())
    rng = np.random.default_rng(0)
    for axis in rng.normal(size=(20, 3)):
        axis = axis / np.linalg.norm(axis)
        c = ways @ axis
        weight = np.sqrt(np.maximum(1 - c * c, 0)) / np.pi**2 if which == 0 else np.maximum(c, 0) / np.pi
        exact = ((weight * area)[..., None] * picture()).sum((0, 1))
        got = [float(around(sky, which, k, *axis.astype(np.float32))) for k in range(3)]
        np.testing.assert_allclose(got, exact, rtol=0.02)


def test_a_turn_carries_the_sky_along() -> None:
    quarter = coefficients(picture(), 90.0)
    rolled = coefficients(np.roll(picture(), -WIDE // 4, axis=1))
    np.testing.assert_allclose(quarter, rolled, atol=1e-5)


def rgbe(colours: np.ndarray) -> np.ndarray:
    mantissa, exponent = np.frexp(colours.max(-1))
    scale = np.where(colours.max(-1) > 0, mantissa * 256 / np.maximum(colours.max(-1), 1e-30), 0)
    return np.concatenate([colours * scale[..., None], exponent[..., None] + 128], -1).astype(np.uint8)


def runs(channel: bytes) -> bytes:
    """Half of a row as repeated bytes where they are, the rest as they stand."""
    out, at = b"", 0
    while at < len(channel):
        same = 1
        while at + same < len(channel) and channel[at + same] == channel[at] and same < 127:
            same += 1
        out += bytes([128 + same, channel[at]]) if same > 2 else bytes([1, channel[at]])
        at += same if same > 2 else 1
    return out


@pytest.mark.parametrize("packed", [False, True])
def test_hdr_pictures_come_back(tmp_path: Path, packed: bool) -> None:
    wanted = np.repeat(picture()[::4, ::8] * 10, 3, axis=1).astype(np.float32)
    pixels = rgbe(wanted)
    height, width = wanted.shape[:2]
    body = b""
    for row in pixels:
        if packed:
            body += bytes([2, 2, width >> 8, width & 255]) + b"".join(runs(row[:, c].tobytes()) for c in range(4))
        else:
            body += row.tobytes()
    file = tmp_path / "sky.hdr"
    file.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width) + body)
    np.testing.assert_allclose(read_hdr(file), wanted, atol=float(wanted.max()) / 100)
    file.write_bytes(file.read_bytes()[:-5])
    with pytest.raises(ValueError, match="ends before"):
        read_hdr(file)


PRESET = """
emitter: {strands: 200, particles: 4}
rules: []
solids: [{kind: sphere, radius: 0.9}]
image: {size: 40x30}
lights: []
ambient: [0, 0, 0]
environment: {image: %s, intensity: 2}
"""


def test_a_picture_lights_the_scene_and_one_that_is_not_there_is_named(tmp_path: Path) -> None:
    preset = tmp_path / "scene.yaml"
    preset.write_text(PRESET % "sky.png")
    with pytest.raises(SceneError, match=r"scene\.yaml:\d+:\d+: environment\.image: .*there is no file .*sky\.png"):
        load(str(preset))
    (tmp_path / "sky.png").write_bytes(b"nothing")
    with pytest.raises(UsageError, match="it is no picture"):
        sky_of(load(str(preset)))
    colours = np.zeros((16, 32, 3), np.uint8)
    colours[:8] = [40, 80, 200]
    colours[8:] = [120, 60, 20]
    Image.fromarray(colours).save(tmp_path / "sky.png")
    image = frames_of(load(str(preset)), 1)[0].image
    upper, lower = image[3:10, 15:25].mean((0, 1)), image[20:27, 15:25].mean((0, 1))
    assert upper[2] > upper[0]
    assert lower[0] > lower[2]


@pytest.mark.parametrize(("path", "words"), [("/dev/null", "no file but a device"), ("/", "a folder")])
def test_what_is_there_and_no_file_is_not_said_to_be_missing(tmp_path: Path, path: str, words: str) -> None:
    (tmp_path / "scene.yaml").write_text(PRESET % path)
    with pytest.raises(SceneError, match=f"environment.image: must be the path of a file, and {path} is {words}"):
        load(str(tmp_path / "scene.yaml"))


def test_a_path_is_meant_from_where_it_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In a preset from the preset's folder, also where another extends it; after --set from here."""
    (tmp_path / "looks").mkdir()
    base, child = tmp_path / "looks" / "base.yaml", tmp_path / "child.yaml"
    base.write_text(PRESET % "sky.png")
    child.write_text("extends: looks/base.yaml\n")
    for place in (tmp_path / "looks" / "sky.png", tmp_path / "here.png"):
        place.write_bytes(b"")
    monkeypatch.chdir(tmp_path)
    for preset in (base, child):
        found = load(str(preset)).environment
        assert found.image == str(tmp_path / "looks" / "sky.png")
    found = load(str(base), ["environment.image=here.png"]).environment
    assert found.image == str(tmp_path / "here.png")
    child.write_text("environment: {intensity: 2}\n")
    with pytest.raises(SceneError, match="must be the path of a lat-long picture"):
        load(str(child))


@pytest.mark.parametrize("grey", [True, False])
def test_sixteen_bits_are_read_by_the_curve_of_eight(tmp_path: Path, grey: bool) -> None:
    codes = np.array([[0, 2000, 32768], [65535, 257, 40000]])
    colours = codes if grey else np.stack([codes, codes[::-1], codes[:, ::-1]], -1)
    (tmp_path / "sky.png").write_bytes(b"".join(png.encode(colours.astype(np.uint16))))
    found = read(str(tmp_path / "sky.png"))
    encoded = codes / 65535
    wanted = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(found[..., 0], wanted, rtol=1e-12)
    np.testing.assert_allclose(found[..., 1], wanted if grey else wanted[::-1], rtol=1e-12)
    np.testing.assert_allclose(found[..., 2], wanted if grey else wanted[:, ::-1], rtol=1e-12)
    Image.fromarray(np.rint(codes / 257).astype(np.uint8)).save(tmp_path / "eight.png")
    np.testing.assert_allclose(found[..., 0], read(str(tmp_path / "eight.png"))[..., 0], atol=0.005)


@pytest.mark.parametrize("size", [(3, 40_000), (300, 500)])
def test_pictures_of_many_pixels_are_read_whole(tmp_path: Path, size: tuple[int, int]) -> None:
    """Part by part, however wide: each is that of sRGB's inverse curve."""
    coded = np.random.default_rng(1).integers(0, 256, (*size, 3), dtype=np.uint8)
    path = tmp_path / "sky.png"
    path.write_bytes(b"".join(png.encode(coded)))
    u = coded / 255
    linear = np.where(u <= 0.04045, u / 12.92, ((u + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(read(str(path)), linear, rtol=1e-12)


def test_pictures_of_other_kinds_are_refused_by_name(tmp_path: Path) -> None:
    """Their samples are no sRGB of 8 or 16 bits, or they are several pictures."""
    grey = Image.new("L", (8, 4), 40)
    float_picture = Image.fromarray(np.full((4, 8), np.nan, np.float32))
    for name, image, more, words in (
        ("sky.tif", float_picture, {}, "a TIFF picture is not read"),
        ("sky.gif", grey, {}, "a GIF picture is not read"),
        ("sky.webp", grey.convert("RGB"), {}, "a WEBP picture is not read"),
        ("ink.jpg", Image.new("CMYK", (8, 4)), {}, "a CMYK JPEG is not read"),
        ("film.png", grey, {"save_all": True, "append_images": [Image.new("L", (8, 4), 90)]}, "an animation"),
    ):
        image.save(tmp_path / name, **more)
        with pytest.raises(UsageError, match=rf"{name}: {words}.*; give a lat-long picture, PNG, JPEG or Radiance"):
            read(str(tmp_path / name))
    grey.save(tmp_path / "sky.jpg")
    assert read(str(tmp_path / "sky.jpg")).shape == (4, 8, 3)


@pytest.mark.parametrize(("width", "height"), [(20000, 10000), (8193, 8192)])
def test_a_picture_too_big_is_told_the_limit_without_warnings(
    tmp_path: Path, width: int, height: int, recwarn: pytest.WarningsRecorder
) -> None:
    small = b"".join(png.encode(np.zeros((1, 1, 3), np.uint8)))
    header = struct.pack(">II", width, height) + small[24:29]
    (tmp_path / "sky.png").write_bytes(
        small[:16] + header + struct.pack(">I", zlib.crc32(b"IHDR" + header)) + small[33:]
    )
    with pytest.raises(UsageError, match=r"sky\.png: .*more than 67,108,864 pixels"):
        read(str(tmp_path / "sky.png"))
    assert not recwarn.list
