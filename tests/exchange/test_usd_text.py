"""Texts of USD whose long arrays are read apart are the layers that Pixar's library makes of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from strandcli.errors import UsageError
from strandcli.exchange.files import ReadOptions, read

ROWS = 6_000
"""Of arrays that are long: of more than 64 KiB of text."""
POINTS = ", ".join(f"({k % 7}, -{k}.125e-3, 1e{k % 9})" for k in range(ROWS))
COUNTS = ", ".join(["         2"] * (ROWS // 2 + 4_000))
CURVES = '#usda 1.0\ndef BasisCurves "a"\n{{\n    uniform token type = "linear"\n    {}\n}}\n'
APART = {
    "default": f"point3f[] points = [{POINTS}]\n    int[] curveVertexCounts = [{COUNTS}]",
    "several moments": f"point3f[] points.timeSamples = {{ 0: [{POINTS}], 2: [(1, 2, 3)], 3.5: [{POINTS}], }}",
    "a comma at the end, and lines": f"point3f[] points = [\n        {POINTS},\n    ]",
    "not finite": f"float3[] primvars:a = [{POINTS}, (nan, inf, -inf)] ( interpolation = \"vertex\" )",
    "rows of two": "texCoord2f[] primvars:st = [" + ", ".join(f"(0.5, {k})" for k in range(9_000)) + "]",
    "single": "float[] widths = [" + ", ".join(f"{k}.1" for k in range(12_000)) + "]",
    "in a variant": f'variantSet "v" = {{\n "x" {{\n float3[] b = [{POINTS}]\n }}\n }}',
}  # fmt: skip
WHOLE = {
    "a type that is not read apart": "double3[] b = [" + POINTS + "]",
    "in a text": f'custom string b = "float3[] c = [{POINTS}]"',
    "in a remark": f"# float3[] c = [{POINTS}]\n    float b = 1",
    "in a dictionary": f"float b = 1 (customData = {{ int[] c = [{COUNTS}] }})",
}


def text_of(path: Path, words: str) -> str:
    """Write a file; returns what Pixar's library reads of it."""
    from pxr import Sdf

    path.write_text(CURVES.format(words))
    layer = Sdf.Layer.OpenAsAnonymous(str(path))
    return layer.ExportToString()


@pytest.mark.parametrize("case", [*APART, *WHOLE])
def test_a_layer_with_open_stage_is_that_of_the_library(case: str, tmp_path: Path) -> None:
    from strandcli.exchange.usd.open_stage import layer_of_text

    path = tmp_path / "a.usd"
    wanted = text_of(path, {**APART, **WHOLE}[case])
    found = layer_of_text(str(path))
    assert (found is None) == (case in WHOLE)
    if found is not None:
        assert found.ExportToString() == wanted
        assert (found.identifier, found.realPath) == (str(path), str(path))


@pytest.mark.parametrize(
    "change", [("(1, -1", "(1 -1"), ("(1, -1", "1, -1"), ("1e8)]", "1e8)"), ("1e7)", "1e7"), ("1e7)", "1e7a)")]
)
def test_the_library_says_what_is_wrong_with_a_long_array(change: tuple[str, str], tmp_path: Path) -> None:
    path = tmp_path / "a.usda"
    path.write_text(CURVES.format(f"point3f[] points = [{POINTS}, (0, 0, 1e8)]".replace(*change, 1)))
    with pytest.raises(UsageError, match=r"(parse error|Tuple nesting) .* it is damaged or no \.usd file"):
        read(path, ReadOptions())
