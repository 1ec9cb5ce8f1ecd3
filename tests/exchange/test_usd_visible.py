"""Curves of USD that are hidden, always or at times."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import usd_kit
from strandcli.exchange.files import read

pytest.importorskip("pxr", reason="Pixar's library is not installed: pip install usd-core")

STRANDS = [np.array([[0, 0, 0], [0, 1, 0]], np.float32)]


@pytest.mark.parametrize("place", ["its own", "that of what holds it"])
def test_visibility_that_changes_or_hides_is_told_wherever_it_is(place: str, tmp_path: Path) -> None:
    changes = '    token visibility.timeSamples = { 1: "inherited", 2: "invisible" }\n'
    hidden = '    token visibility = "invisible"\n'
    body = ""
    for name, words in (("shown", changes), ("hidden", hidden)):
        own, held = (words, "") if place == "its own" else ("", words)
        body += f'def Xform "{name}"\n{{\n{held}' + usd_kit.prim(STRANDS, "a", more=own) + "}\n"
    path = tmp_path / "a.usda"
    path.write_text(usd_kit.HEAD + body)
    found = read(path)
    assert found.objects == ("/shown/a",)
    assert found.source.facts["not_read"] == {"invisible": 1}
    assert found.source.facts["changing"] == ["visibility"]
