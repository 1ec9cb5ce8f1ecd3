"""Cubic curves of USD: the points that strands get of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import exchange_kit as kit
import usd_kit
from strandcli.errors import UsageError
from strandcli.exchange import splines
from strandcli.exchange.files import read, write
from strandcli.exchange.strands import Attribute, Strands, TimeSample
from tests.exchange.test_usd import STRANDS, opened, read_text


def test_points_are_joined_smoothly_where_that_is_asked_for(tmp_path: Path) -> None:
    held = kit.of([STRANDS[0], STRANDS[1][:2], STRANDS[2]])
    width = np.arange(10, dtype=np.float32)
    held = Strands(held.first, held.points, {"width": Attribute("point", width)})
    moved = [TimeSample(i / 24, held.points + np.float32(i)) for i in range(2)]
    assert write(tmp_path / "a.usdc", held, moved, basis="catmullRom") == []
    _, curves = opened(tmp_path / "a.usdc")
    told = [curves.GetTypeAttr().Get(), curves.GetBasisAttr().Get(), curves.GetWrapAttr().Get()]
    assert told == ["cubic", "catmullRom", "pinned"]
    assert np.array(curves.GetPointsAttr().Get(1)).tobytes() == moved[1].points.tobytes()
    from pxr import Usd

    assert curves.ComputeInterpolationForSize(len(width), Usd.TimeCode(0)) in ("vertex", "varying")
    made = read(tmp_path / "a.usdc")
    each = (made.counts() - 1) // (held.counts() - 1)
    assert (made.counts() == each[0] * (held.counts() - 1) + 1).all()
    assert each[0] > 1
    ends = np.concatenate([made.first[i] + each[0] * np.arange(n) for i, n in enumerate(held.counts())])
    np.testing.assert_allclose(made.points[ends], held.points, rtol=1e-6)
    np.testing.assert_allclose(made.attributes["width"].values[ends], width, atol=1e-6)
    with pytest.raises(UsageError, match=r"\.hair is written with straight segments; .* are written to \.usd, \.usda"):
        write(tmp_path / "a.hair", held, basis="catmullRom")


def bernstein(points: Any, t: Any) -> Any:
    """The point of a Bezier curve of any degree, by de Casteljau's construction."""
    points = points.astype(np.float64)
    while len(points) > 1:
        points = points[:-1] * (1 - t) + points[1:] * t
    return points[0]


def cardinal(t: float) -> float:
    """The cubic B-spline of knots -2 … 2, by de Boor's recursion from the unit step."""

    def step(i: float, degree: int) -> float:
        if degree == 0:
            return float(i <= t < i + 1)
        return ((t - i) * step(i, degree - 1) + (i + degree + 1 - t) * step(i + 1, degree - 1)) / degree

    return step(-2, 3)


@pytest.mark.parametrize("wrap", splines.WRAPS)
def test_b_splines_are_sums_of_cardinal_ones(wrap: str) -> None:
    curve = np.random.default_rng(4).normal(size=(6, 3))
    basis = splines.Basis("cubic", "bspline", wrap)
    made = splines.evaluated(np.array([6]), curve, basis, 5)
    knots = {"nonperiodic": (1, 4), "periodic": (1, 7), "pinned": (0, 5)}[wrap]
    held = {i: curve[i % 6] for i in range(-2, 12)}
    if wrap == "pinned":
        held[-1], held[6] = 2 * curve[0] - curve[1], 2 * curve[5] - curve[4]
    places = np.linspace(*knots, 5 * (knots[1] - knots[0]) + 1)
    want = [sum(cardinal(t - i) * point for i, point in held.items() if abs(t - i) < 2) for t in places]
    np.testing.assert_allclose(made, np.array(want), rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("wrap", splines.WRAPS)
def test_catmull_rom_splines_go_through_their_points_with_the_slopes_of_chords(wrap: str) -> None:
    curve = np.random.default_rng(5).normal(size=(6, 3))
    basis = splines.Basis("cubic", "catmullRom", wrap)
    made = splines.evaluated(np.array([6]), curve, basis, 1000).astype(np.float64)
    through = {"nonperiodic": [1, 2, 3, 4], "periodic": [1, 2, 3, 4, 5, 0, 1], "pinned": [0, 1, 2, 3, 4, 5]}[wrap]
    np.testing.assert_allclose(made[::1000], curve[through], atol=1e-6)
    for place, i in enumerate(through[1:-1], 1):
        slope = (made[1000 * place + 1] - made[1000 * place - 1]) * 500
        np.testing.assert_allclose(slope, (curve[(i + 1) % 6] - curve[(i - 1) % 6]) / 2, atol=1e-2)


@settings(max_examples=20, deadline=None)
@given(
    basis=st.sampled_from(["bezier", "bspline", "catmullRom"]),
    wrap=st.sampled_from(splines.WRAPS), kind=st.sampled_from([0, 1]),
    counts=st.lists(st.integers(0, 14), min_size=1, max_size=8), seed=st.integers(0, 99),
)  # fmt: skip
def test_counts_agree_with_pixar(basis: str, wrap: str, kind: int, counts: list[int], seed: int) -> None:
    """Sizes of varying values are those of the schema; each point on a curve is within the bound of its segments."""
    from pxr import Usd, UsdGeom

    told = splines.Basis("cubic" if kind else "linear", basis, wrap)
    pieces = told.pieces(np.array(counts))
    held = np.array([count for count, piece in zip(counts, pieces, strict=True) if piece > 0], np.int64)
    stage = Usd.Stage.CreateInMemory()
    curves = UsdGeom.BasisCurves.Define(stage, "/a")
    curves.CreateTypeAttr(told.type)
    curves.CreateBasisAttr(basis)
    curves.CreateWrapAttr(wrap)
    curves.CreateCurveVertexCountsAttr(held.tolist())
    if wrap != "pinned" and (kind or wrap == "nonperiodic"):  # the library does not count what pinning adds
        assert curves.ComputeVaryingDataSize(Usd.TimeCode.Default()) == told.varying(held).sum()
    points = np.random.default_rng(seed).normal(size=(int(held.sum()), 3)).astype(np.float32)
    each, off = splines.points_a_piece(held, points, told)
    coarse, fine = (splines.evaluated(held, points, told, one) for one in (each, 4 * each))
    assert coarse.shape[0] == splines.new_counts(held, told, each).sum()
    begin = np.concatenate([[0], np.cumsum(splines.new_counts(held, told, each))])
    begin_fine = np.concatenate([[0], np.cumsum(splines.new_counts(held, told, 4 * each))])
    for i in range(held.size):
        few, many = coarse[begin[i] : begin[i + 1]], fine[begin_fine[i] : begin_fine[i + 1]]
        assert np.abs(many[::4] - few).max() < 1e-5
        chord = np.repeat(few[:-1], 4, axis=0) + np.tile([[0], [0.25], [0.5], [0.75]], (len(few) - 1, 1)) * np.repeat(
            np.diff(few, axis=0), 4, axis=0
        )
        assert np.linalg.norm(many[:-1] - chord, axis=1).max() <= off + 1e-5


def test_values_of_cubic_curves_follow_them() -> None:
    curve = np.random.default_rng(6).normal(size=(7, 3)).astype(np.float32)
    more = '    float[] primvars:a = [0, 1, 4] (\n        interpolation = "varying"\n    )\n'
    more += f'    float3[] primvars:b = {usd_kit.tuples(curve)} (\n        interpolation = "vertex"\n    )\n'
    more += '    int[] primvars:c = [0, 1, 4] (\n        interpolation = "varying"\n    )\n'
    found = read_text(usd_kit.HEAD + usd_kit.prim([curve], basis="bezier", more=more))
    each = found.source.facts["points_a_piece"][0]
    want = np.interp(np.arange(2 * each + 1) / each, [0, 1, 2], [0, 1, 4])
    np.testing.assert_allclose(found.attributes["a"].values, want, rtol=1e-6)
    assert found.attributes["b"].values.tobytes() == found.points.tobytes()
    assert found.source.facts["attributes_not_read"] == ["c"]


def test_hermite_curves_have_their_points_and_tangents() -> None:
    """On each piece the cubic with these ends and slopes; a transform does not shift tangents."""
    generator = np.random.default_rng(7)
    points, tangents = generator.normal(size=(2, 4, 3)).astype(np.float32)
    body = (
        'def Xform "x"\n{\n    double3 xformOp:translate = (1, 2, 3)\n'
        '    uniform token[] xformOpOrder = ["xformOp:translate"]\n    def HermiteCurves "h"\n    {\n'
        f"        int[] curveVertexCounts = [4]\n        point3f[] points = {usd_kit.tuples(points)}\n"
        f"        vector3f[] tangents = {usd_kit.tuples(tangents)}\n        float[] widths = [1, 2, 4, 8] (\n"
        '            interpolation = "vertex"\n        )\n    }\n}\n'
    )
    found = read_text(usd_kit.HEAD + body)
    assert found.source.facts["basis"] == ["cubic hermite"]
    each = found.source.facts["points_a_piece"][0]
    assert found.points.shape[0] == 3 * each + 1
    for place, point in enumerate(found.points):
        piece = min(place // each, 2)
        t = (place - piece * each) / each
        (p, q), (u, v) = points[piece : piece + 2], tangents[piece : piece + 2]
        want = (1 + 2 * t) * (1 - t) ** 2 * p + t * t * (3 - 2 * t) * q + t * (1 - t) * ((1 - t) * u - t * v)
        np.testing.assert_allclose(point, want + np.array([1, 2, 3]), rtol=1e-5, atol=1e-5)
    assert found.attributes["width"].values[::each].tolist() == [1, 2, 4, 8]


def test_nurbs_curves_reach_ends_that_their_knots_clamp() -> None:
    """Between, those of one span are Bezier curves of their order."""
    curve = np.random.default_rng(8).normal(size=(7, 3)).astype(np.float32)
    body = (
        'def NurbsCurves "n"\n{\n    int[] curveVertexCounts = [4, 3]\n    int[] order = [4, 3]\n'
        "    double[] knots = [0, 0, 0, 0, 2, 2, 2, 2, 1, 1, 1, 5, 5, 5]\n"
        f"    point3f[] points = {usd_kit.tuples(curve)}\n    double[] pointWeights = WEIGHTS\n}}\n"
    )
    found = read_text(usd_kit.HEAD + body.replace("WEIGHTS", "[1, 1, 1, 1, 1, 1, 1]"))
    assert found.source.facts["basis"] == ["NURBS"]
    each = found.source.facts["points_a_piece"][0]
    want = [bernstein(part, t / each) for part in (curve[:4], curve[4:]) for t in range(each + 1)]
    np.testing.assert_allclose(found.points, want, rtol=1e-5, atol=1e-6)
    with pytest.raises(UsageError, match="/n: NURBS with weights that differ are not read"):
        read_text(usd_kit.HEAD + body.replace("WEIGHTS", "[1, 1, 1, 1, 1, 1, 2]"))
