"""`look: source` fixes what was not written, and refuses what was written otherwise."""

from __future__ import annotations

import dataclasses
from unittest.mock import patch

from scene_kit import complaints, scene
from strandcli.scene import dump, quality
from strandcli.scene.quality import settle


def test_a_look_allows_what_agrees_with_it() -> None:
    for text in (
        "look: source",
        "look: source\nimage: {resolver: zbuffer}",
        "look: source\nlights: [{kind: point, shadow: {model: 'off'}}, {kind: directional}]",
        "look: free\nimage: {resolver: sorted}",
    ):
        made = scene(text)
        assert made.look == text.split()[1]
        assert scene(dump(made)) == made


def test_a_clash_names_both_and_its_line() -> None:
    (line,) = complaints("look: source\nimage:\n  resolver: sorted\n")
    assert line.startswith("p.yaml:3:")
    assert "image.resolver" in line
    assert "'sorted' clashes with look: source, which draws with zbuffer; take one of the two out" in line


def test_a_panels_look_clashes_with_what_all_panels_share() -> None:
    (line,) = complaints("image: {resolver: sorted}\npanels:\n  - label: a\n    set: {look: source}\n")
    assert line.startswith("p.yaml:3:")
    assert "'sorted' clashes with look: source" in line


def test_what_is_not_written_gets_the_looks_value() -> None:
    """Also where that is not the default, and for any light."""
    fixed = {"image.resolver": ("sorted",), "lights.*.shadow.model": ("off",)}
    made = scene("look: source\nlights: [{kind: point}, {kind: directional}]")
    with patch.dict(quality.LOOKS, {"source": fixed}):
        settled, clashes = settle(made, ())
        assert not clashes
        assert settled.image == dataclasses.replace(made.image, resolver="sorted")
        assert [light.shadow.model for light in settled.lights] == ["off", "off"]
        settled, clashes = settle(made, ("lights.1.shadow.model",))
        assert [path for path, _ in clashes] == ["lights.1.shadow.model"]
        assert settled.lights[0].shadow.model == "off"
        assert settle(dataclasses.replace(made, look="free"), ())[0].image.resolver == "zbuffer"
