"""Widths of a file's strands, in records and in what is exported."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import exchange_kit
import usd_kit
from groom_file_kit import Strand, hanging, image, scene, write
from strandcli.exchange import files
from strandcli.exchange.strands import Attribute, Strands
from strandcli.groom_file import from_file
from strandcli.run import pipeline
from strandcli.run.export import drawn_strands
from strandcli.scene.model import Scene
from tests.groom_file.test_followers import curls, moving

Floats = npt.NDArray[np.float32]
NAMES = {"width": 1.0, "widths": 1.0, "groom_width": 1.0, "thickness": 1.0, "pscale": 2.0}
"""Of widths in files; a radius counts twice."""


def with_widths(strands: Sequence[Strand], widths: Floats, name: str = "width", domain: Any = "point") -> Strands:
    found = exchange_kit.of(strands)
    return Strands(found.first, found.points, {name: Attribute(domain, widths)})


def waves(counts: Sequence[int], least: float = 0.002, most: float = 0.02) -> Floats:
    """A width for each point of strands of so many: waves along them, of a phase of their own."""
    rng = np.random.default_rng(3)
    parts = [np.sin(7 * np.linspace(0, 1, count) + 6 * rng.random()) for count in counts]
    return ((least + most) / 2 + (most - least) / 2 * np.concatenate(parts)).astype(np.float32)


def exported(given: Scene, level: int | None = 0) -> Strands:
    (frame,) = drawn_strands(given, [1], level=level)
    return frame.strands


def own_width(given: Scene) -> Floats:
    return np.asarray(exported(given).attributes["width"].values)


def test_strands_have_the_widths_of_the_file(tmp_path: Path) -> None:
    strands = hanging([8] * 60)
    each = np.repeat(np.where(np.arange(60) < 30, 0.04, 0.01).astype("<f4"), 8)
    path = tmp_path / "a.hair"
    path.write_bytes(exchange_kit.hair(strands, more=each.tobytes(), flags=4))
    given = scene(path, emitter__groom__scale=2.0)
    assert given.material.width == pytest.approx(0.05)
    groom = from_file(given.emitter.groom, given.seed).groom  # type: ignore[arg-type]
    assert groom.widths.shares is None
    assert groom.emitted(groom.widths.scale) == pytest.approx([1.6] * 30 + [0.4] * 30)
    alike = tmp_path / "b.hair"
    alike.write_bytes(exchange_kit.hair(strands, more=np.full(480, 0.025, "<f4").tobytes(), flags=4))
    uneven, even = (image(scene(one, emitter__groom__scale=2.0)) for one in (path, alike))
    assert np.abs(uneven.astype(int) - even).max() > 20
    bare = write(tmp_path / "c.data", strands)
    plain = scene(bare, emitter__groom__scale=2.0, material__width=0.05, material__taper=0)
    assert (image(plain) == even).all()


def test_a_width_of_all_is_that_of_every_point(tmp_path: Path) -> None:
    """Nothing tapers but what a preset says: a taper that it has acts on widths of a file too."""
    path = tmp_path / "a.usda"
    constant = '    float[] widths = [0.01] (\n        interpolation = "constant"\n    )\n'
    head = usd_kit.HEAD.replace("0.01", "1").replace('"Z"', '"Y"')
    path.write_text(head + usd_kit.prim(hanging([7] * 30), basis="bspline", wrap="pinned", more=constant))
    np.testing.assert_allclose(own_width(scene(path)), 0.01, rtol=1e-6)
    found = exported(scene(path, material__taper=0.6)).attributes["width"].values.reshape(30, -1)
    along = np.linspace(0, 1, found.shape[1])
    np.testing.assert_allclose(found, np.broadcast_to(0.01 * (1 - 0.6 * along), found.shape), rtol=1e-5)
    bare = scene(write(tmp_path / "b.data", hanging([7] * 30)))
    assert (bare.material.drawn_taper, scene(path).material.taper) == (0.7, 0.0)


def test_widths_that_some_curves_of_a_file_lack_are_told(tmp_path: Path) -> None:
    path, widths = tmp_path / "a.usda", '    float[] widths = [0.01] (\n        interpolation = "constant"\n    )\n'
    prims = usd_kit.prim(hanging([7] * 30), more=widths) + usd_kit.prim(hanging([7] * 5, seed=2), name="bare")
    path.write_text(usd_kit.HEAD + prims)
    notes = from_file(scene(path).emitter.groom, 0).notes  # type: ignore[arg-type]
    assert any("not all of its curves have them" in words for words in notes)


@pytest.mark.parametrize("name", [".npz", ".hair", ".usdc"])
def test_widths_come_back_from_a_file_that_was_exported(tmp_path: Path, name: str) -> None:
    strands, widths = hanging([9] * 20), waves([9] * 20)
    first, second = tmp_path / f"a{name}", tmp_path / f"b{name}"
    files.write(first, with_widths(strands, widths))
    found = exported(scene(first))
    np.testing.assert_allclose(found.attributes["width"].values, widths, rtol=1e-6)
    files.write(second, found)
    again = exported(scene(second))
    np.testing.assert_array_equal(again.points, found.points)
    np.testing.assert_allclose(again.attributes["width"].values, widths, rtol=1e-6)
    tapered = own_width(scene(first, material__taper=0.5))
    np.testing.assert_allclose(tapered, widths * np.tile(np.linspace(1, 0.5, 9), 20), rtol=1e-6)


@pytest.mark.parametrize("name", ["thickness", "pscale"])
def test_other_names_of_widths_count_as_well(tmp_path: Path, name: str) -> None:
    strands, widths = hanging([9] * 20), waves([9] * 20)
    path = tmp_path / "a.npz"
    np.savez(path, positions=np.stack(strands), **{name: widths.reshape(20, 9)})
    np.testing.assert_allclose(own_width(scene(path)), NAMES[name] * widths, rtol=1e-6)
    np.savez(path, positions=np.stack(strands), **{name: widths[:20]})
    np.testing.assert_allclose(own_width(scene(path)), NAMES[name] * np.repeat(widths[:20], 9), rtol=1e-6)


def test_curves_have_widths_between_their_points(tmp_path: Path) -> None:
    widths = waves([6] * 20)
    files.write(tmp_path / "a.npz", with_widths(hanging([6] * 20), widths))
    found = exported(scene(tmp_path / "a.npz"), level=3).attributes["width"].values.reshape(20, -1)
    places = np.linspace(0, 5, found.shape[1])
    want = np.stack([np.interp(places, np.arange(6), own) for own in widths.reshape(20, 6)])
    np.testing.assert_allclose(found, want, atol=1e-7)


def test_strands_of_unlike_numbers_of_points_have_widths_at_all_that_are_added(tmp_path: Path) -> None:
    counts = [3, 9, 4, 2] * 10
    strands, widths = hanging(counts), waves(counts)
    files.write(tmp_path / "a.npz", with_widths(strands, widths))
    found = exported(scene(tmp_path / "a.npz"))
    first = np.cumsum([0, *counts])
    for s, (points, own) in enumerate(zip(found.points.reshape(40, 9, 3),
                                          found.attributes["width"].values.reshape(40, 9), strict=True)):  # fmt: skip
        theirs, wide = strands[s], widths[first[s] : first[s + 1]]
        at = np.append(0, np.cumsum(np.linalg.norm(np.diff(theirs.astype(float), axis=0), axis=1)))
        here = np.append(0, np.cumsum(np.linalg.norm(np.diff(points.astype(float), axis=0), axis=1)))
        np.testing.assert_allclose(own, np.interp(here, at, wide), atol=2e-6)


def test_strands_that_follow_have_the_widths_of_their_points(tmp_path: Path) -> None:
    """Of the points that are left out, the edges are within the tolerance of those of the strand that is drawn."""
    strands = curls(60, points=200)
    along = np.linspace(0, 1, 200)
    widths = np.concatenate([0.03 + 0.02 * np.sin(45 * along + k) for k in range(60)]).astype(np.float32)
    files.write(tmp_path / "a.npz", with_widths(strands, widths))
    given = moving(tmp_path / "a.npz", emitter__groom__guides=10)
    known = given.emitter.followers
    assert known.points < 200
    size = given.emitter.groom.scale or 1.0
    strands, widths = [(size * one).astype(np.float32) for one in strands], np.float32(size) * widths
    found = exported(given)
    for s, (points, own) in enumerate(zip(found.points.reshape(60, -1, 3),
                                          found.attributes["width"].values.reshape(60, -1), strict=True)):  # fmt: skip
        places = [int(np.linalg.norm(strands[s] - point, axis=1).argmin()) for point in points]
        np.testing.assert_allclose(own, widths[200 * s : 200 * (s + 1)][places], rtol=1e-5)
        at = np.append(0, np.cumsum(np.linalg.norm(np.diff(strands[s].astype(float), axis=0), axis=1)))
        off = np.interp(at, at[places], own) - widths[200 * s : 200 * (s + 1)]
        assert np.abs(off).max() / 2 < 1.2 * known.tolerance


@pytest.mark.parametrize(("resolver", "width"), [("sorted", 0.3), ("zbuffer", 3.0)])
def test_the_mask_is_the_area_of_a_strand(tmp_path: Path, resolver: str, width: float) -> None:
    """Of one that is straight, its length times its mean width, pixels."""
    t, metre = np.linspace(0, 1, 40), 50.0
    line = np.stack([0.3 * t, t, 0 * t], 1).astype(np.float32)
    widths = (width / metre * (0.55 + 0.4 * np.cos(5 * t))).astype(np.float32)
    files.write(tmp_path / "a.npz", with_widths([line], widths))
    camera = {"kind": "orthographic", "height": 72 / metre, "fit": None, "position": [0, 0, 3], "target": [0, 0, 0]}
    picture = {"size": (72, 72), "resolver": resolver, "supersample": 4 if resolver == "zbuffer" else 1}
    given = scene(
        tmp_path / "a.npz", emitter__groom__place="origin", image__aovs=("mask",),
        **{f"camera__{key}": value for key, value in camera.items()},
        **{f"image__{key}": value for key, value in picture.items()},
    )  # fmt: skip
    (frame,) = pipeline.render(given, [1])
    want = float(np.hypot(0.3, 1) * metre * metre * np.trapezoid(widths.astype(float), t))
    assert frame.aovs["mask"].sum(dtype=float) == pytest.approx(want, rel=0.003)


@pytest.mark.parametrize(("count", "width"), [(60, 1e3), (60, 0.0)])
def test_widths_that_cannot_be_meant_are_left_out(tmp_path: Path, count: int, width: float) -> None:
    path = tmp_path / "a.hair"
    more = np.full(8 * count, width, "<f4").tobytes()
    path.write_bytes(exchange_kit.hair(hanging([8] * count), more=more, flags=4))
    found = from_file(scene(path).emitter.groom, 0)  # type: ignore[arg-type]
    assert found.groom.widths is None
    assert any("widths of the file are left out" in words for words in found.notes)
    assert scene(path).material.drawn_taper == 0.7
