"""Colours of a file's strands, in records and in pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import exchange_kit
from groom_file_kit import SMALL, Strand, drawn, hanging, image, scene
from strandcli.groom_file import from_file


def coloured(path: Path, strands: list[Strand], colours: npt.NDArray[np.floating]) -> Path:
    """A .hair file of strands of five points with a colour (S, 3) each."""
    each = np.repeat(colours, 5, axis=0).astype("<f4")
    path.write_bytes(exchange_kit.hair(strands, more=each.tobytes(), flags=16))
    return path


@pytest.mark.parametrize("count", [3, 2000])
def test_each_strand_has_its_colour(tmp_path: Path, count: int) -> None:
    colours = np.random.default_rng(count).random((2000, 3)).astype(np.float32)[np.arange(2000) % count]
    path = coloured(tmp_path / "a.hair", hanging([5] * 2000), colours)
    given = scene(path)
    found = from_file(given.emitter.groom, 0)
    groom = found.groom
    rows = np.rint((groom.tones + 1) / 2 * (len(groom.colours) - 1)).astype(int)
    own = groom.colours[rows]
    assert np.abs(groom.emitted(own) - colours).max() < (1e-6 if count < 256 else 0.4)
    assert np.abs(groom.emitted(own) - colours).mean() < (1e-6 if count < 256 else 0.06)
    np.testing.assert_allclose(found.colour, colours.mean(axis=0), atol=0.01)
    assert any("have the file's colours" in one for one in found.notes)


def along(groom: Any) -> npt.NDArray[np.float32]:
    """(S, ALONG, 3): the colours that strands are drawn with, in the order of the file."""
    rows = np.rint((groom.tones + 1) / 2 * (groom.colours.shape[1] - 1)).astype(int)
    return np.asarray(groom.emitted(groom.colours.transpose(1, 0, 2)[rows]))


def test_colours_stay_at_their_points(tmp_path: Path) -> None:
    """Where colours are taken along a strand, they are those of the points that are drawn there."""
    counts = [5, 2, 9, 3] * 15
    strands = hanging(counts)
    colours = np.random.default_rng(1).random((sum(counts), 3)).astype("<f4")
    path = tmp_path / "a.hair"
    path.write_bytes(exchange_kit.hair(strands, more=colours.tobytes(), flags=16))
    found = from_file(scene(path).emitter.groom, 0).groom  # type: ignore[arg-type]
    for strand, line, own, made in zip(
        strands, drawn(scene(path)), np.split(colours, np.cumsum(counts)[:-1]), along(found), strict=True
    ):
        places = [int(np.flatnonzero((line == point).all(axis=1))[0]) / (len(line) - 1) for point in strand]
        want = [np.interp(np.linspace(0, 1, 17), places, column) for column in own.T]
        np.testing.assert_allclose(made, np.transpose(want), atol=1e-6)


def test_strands_are_drawn_with_colours_that_change_along_them(tmp_path: Path) -> None:
    """As those of a material whose tips have another colour, but that light between strands has the mean of both."""
    colours = np.linspace([0.6, 0.02, 0.02], [0.02, 0.5, 0.3], 5)
    path = tmp_path / "a.hair"
    more = np.tile(colours, (400, 1)).astype("<f4").tobytes()
    path.write_bytes(exchange_kit.hair(hanging([5] * 400), more=more, flags=16))
    plain = {"emitter.groom.colours": "none", "material.colour_variation": 0, "material.pigment": "rgb"}
    ends = {"material.colour": colours[0].tolist(), "material.tip_colour": colours[-1].tolist()}
    own = image(scene(path, **SMALL)).astype(int)
    other = image(scene(path, **{**SMALL, **plain, **ends})).astype(int)
    one = image(scene(path, **{**SMALL, **plain, "material.colour": colours.mean(axis=0).tolist()})).astype(int)
    assert np.abs(own - other).mean() < 0.25 * np.abs(own - one).mean()
    redder = own[..., 0] - own[..., 1]
    assert redder[:20].max() > 20
    assert redder[28:].min() < -20


def test_colours_that_are_none_are_left_out(tmp_path: Path) -> None:
    white = coloured(tmp_path / "a.hair", hanging([5] * 40), np.ones((40, 3)))
    some = coloured(tmp_path / "b.hair", hanging([5] * 40), np.random.default_rng(1).random((40, 3)))
    for given in (scene(white), scene(some, **{"emitter.groom.colours": "none"})):
        assert from_file(given.emitter.groom, 0).groom.colours is None
        assert given.material.pigment == "brown"
