"""What strands absorb: names, melanin, colours and how strands differ."""

from __future__ import annotations

import numpy as np
import pytest

from strandcli.draw.fibre import pigment
from strandcli.draw.lighting.palette import Palette, tint_table
from strandcli.scene.model import PIGMENTS, Material

B = 0.3


def test_every_pigment_that_a_preset_may_name_is_known() -> None:
    assert set(PIGMENTS) == {"rgb", *pigment.CONCENTRATIONS}


def test_colour_and_absorption_are_inverses() -> None:
    colours = np.array([[0.22, 0.11, 0.05], [0.9, 0.8, 0.7], [1.0, 0.5, 1e-3]])
    np.testing.assert_allclose(pigment.mass_colour(pigment.absorption(colours, B), B), colours, rtol=1e-12)


def test_kinds_of_hair_are_as_dark_and_as_red_as_their_names() -> None:
    colours = {name: pigment.colour_of(Material(pigment=name), B) for name in pigment.CONCENTRATIONS}
    dark_to_pale = ["black", "dark_brown", "brown", "light_brown", "dark_blond", "blond", "platinum", "white"]
    luminance = [colours[name].mean() for name in dark_to_pale]
    assert (np.diff(luminance) > 0).all()
    redness = {name: colour[0] / colour[2] for name, colour in colours.items()}
    assert redness["red"] > redness["light_brown"] > redness["blond"] > redness["white"]
    assert colours["white"].min() > 0.6


def test_a_concentration_that_is_written_replaces_that_of_the_kind() -> None:
    kind = Material(pigment="brown")
    more = Material(pigment="brown", pheomelanin=1.0)
    eumelanin, pheomelanin = pigment.CONCENTRATIONS["brown"]
    expected = pigment.absorption_of(kind, B) + (1.0 - pheomelanin) * pigment.PHEOMELANIN
    np.testing.assert_allclose(pigment.absorption_of(more, B), expected)
    alone = Material(eumelanin=eumelanin, colour=(1.0, 0.0, 0.0))
    np.testing.assert_allclose(pigment.absorption_of(alone, B), eumelanin * pigment.EUMELANIN)


@pytest.mark.parametrize("kind", [{"pigment": "red"}, {"colour": (0.4, 0.2, 0.1)}], ids=["melanin", "rgb"])
def test_strands_differ_by_their_tone_and_tips_from_roots(kind: dict[str, object]) -> None:
    material = Material(**kind, tip_colour=(0.6, 0.5, 0.4), colour_variation=0.5)  # type: ignore[arg-type]
    table = tint_table(material, B, pigment.absorption_of(material, B))
    middle = table.shape[1] // 2
    np.testing.assert_allclose(table[0, middle, :3], pigment.colour_of(material, B), rtol=1e-6)
    np.testing.assert_allclose(table[0, middle, 3:], 0.0, atol=1e-6)
    np.testing.assert_allclose(table[-1, middle, :3], (0.6, 0.5, 0.4), rtol=1e-6)
    assert (np.diff(table[:, :, 0], axis=1) > 0).all()
    assert (np.diff(table[:, :, 3:], axis=1) < 0).all()


def test_a_share_of_strands_is_grey() -> None:
    palette = Palette(Material(model="chiang", pigment="black", grey=0.25))
    assert len(palette.arrays.paths) > 0
    white = (palette.tint[0, :, :3] == 1.0).all(-1)
    assert white.mean() == pytest.approx(0.25, abs=0.02)
    assert Palette(Material(pigment="black")).tint is None


def test_strands_without_pigment_may_have_a_colour_of_their_own() -> None:
    straw = (0.5, 0.35, 0.1)
    palette = Palette(Material(model="chiang", colour=(0.1, 0.3, 0.05), grey=0.25, grey_colour=straw))
    assert len(palette.arrays.paths) > 0
    other = np.isclose(palette.tint[:, :, :3], straw, atol=1e-6).all(-1)
    assert other.mean() == pytest.approx(0.25, abs=0.02)
    base, own = (pigment.absorption(colour, 0.3) for colour in ((0.1, 0.3, 0.05), straw))
    np.testing.assert_allclose(palette.tint[other][:, 3:] + base, np.tile(own, (other.sum(), 1)), rtol=1e-5)
