"""Cubic curves of USD and Alembic: the points that strands get of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import usd_kit
from abc_kit import Builder
from strandcli.errors import UsageError
from strandcli.exchange import splines
from strandcli.exchange.splines import Basis, ControlCurves, note_of
from strandcli.exchange.strands import Strands
from tests.exchange.test_abc import read_bytes
from tests.exchange.test_usd import read_text

BEZIER, BSPLINE, CATMULL_ROM, HERMITE = range(1, 5)
NAMES = {BEZIER: "bezier", BSPLINE: "bspline", CATMULL_ROM: "catmullRom"}
CUBIC, LINEAR, VARIABLE = range(3)


def evaluated(curve: Any, basis: Basis, each: int) -> Any:
    """Points on one curve."""
    return ControlCurves("", np.array([len(curve)]), basis, each).points(curve)[0].astype(np.float64)


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
    made = evaluated(curve, Basis("cubic", "bspline", wrap), 5)
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
    made = evaluated(curve, Basis("cubic", "catmullRom", wrap), 1000)
    through = {"nonperiodic": [1, 2, 3, 4], "periodic": [1, 2, 3, 4, 5, 0, 1], "pinned": [0, 1, 2, 3, 4, 5]}[wrap]
    np.testing.assert_allclose(made[::1000], curve[through], atol=1e-6)
    for place, i in enumerate(through[1:-1], 1):
        slope = (made[1000 * place + 1] - made[1000 * place - 1]) * 500
        np.testing.assert_allclose(slope, (curve[(i + 1) % 6] - curve[(i - 1) % 6]) / 2, atol=1e-2)


def test_bezier_curves_are_de_casteljaus() -> None:
    curve = np.random.default_rng(6).normal(size=(7, 3))
    made = evaluated(curve, Basis("cubic", "bezier"), 8)
    for place, point in enumerate(made):
        piece = min(place // 8, 1)
        control, t = curve[3 * piece : 3 * piece + 4], place / 8 - piece
        while len(control) > 1:
            control = control[:-1] * (1 - t) + control[1:] * t
        np.testing.assert_allclose(point, control[0], atol=1e-6)


@pytest.mark.parametrize("each", [2, 4, 9])
@pytest.mark.parametrize("name", NAMES.values())
def test_curves_leave_segments_by_no_more_than_is_told(name: str, each: int) -> None:
    curve, basis = np.random.default_rng(7).normal(size=(7, 3)), Basis("cubic", name)
    points, told = ControlCurves("", np.array([7]), basis, each).points(curve)
    fine = evaluated(curve, basis, 64 * each)
    worst = 0.0
    for i in range(len(points) - 1):
        between, along = fine[64 * i : 64 * (i + 1) + 1] - points[i], points[i + 1] - points[i]
        share = np.clip(between @ along / (along @ along), 0, 1)
        worst = max(worst, float(np.linalg.norm(between - share[:, None] * along, axis=1).max()))
    assert worst <= told < 3 * worst


@settings(max_examples=20, deadline=None)
@given(
    basis=st.sampled_from(list(NAMES.values())), wrap=st.sampled_from(splines.WRAPS), kind=st.sampled_from([0, 1]),
    counts=st.lists(st.integers(0, 14), min_size=1, max_size=8), seed=st.integers(0, 99),
)  # fmt: skip
def test_counts_agree_with_pixar(basis: str, wrap: str, kind: int, counts: list[int], seed: int) -> None:
    """Sizes of varying values are those of the schema; each curve has the points that it has alone."""
    from pxr import Usd, UsdGeom

    told = Basis("cubic" if kind else "linear", basis, wrap)
    pieces = told.pieces(np.array(counts))
    held = np.array([count for count, piece in zip(counts, pieces, strict=True) if piece > 0], np.int64)
    stage = Usd.Stage.CreateInMemory()
    curves = UsdGeom.BasisCurves.Define(stage, "/a")
    curves.CreateTypeAttr(told.type)
    curves.CreateBasisAttr(basis)
    curves.CreateWrapAttr(wrap)
    curves.CreateCurveVertexCountsAttr(held.tolist())
    if wrap != "pinned" and (kind or wrap == "nonperiodic"):  # the library does not count what pinning adds
        assert curves.ComputeVaryingDataSize(Usd.TimeCode.Default()) == told.joints(held).sum()
    points = np.random.default_rng(seed).normal(size=(int(held.sum()), 3)).astype(np.float32)
    made = ControlCurves("", held, told, 3)
    parts = np.split(points, np.cumsum(held)[:-1]) if held.size else []
    want = [ControlCurves("", np.array([len(one)]), told, 3).points(one)[0] for one in parts]
    np.testing.assert_array_equal(made.points(points)[0], np.concatenate([np.zeros((0, 3), np.float32), *want]))
    assert made.point_counts().tolist() == [len(one) for one in want]


def test_values_of_cubic_curves_follow_them() -> None:
    curve = np.random.default_rng(6).normal(size=(7, 3)).astype(np.float32)
    more = '    float[] primvars:a = [0, 1, 4] (\n        interpolation = "varying"\n    )\n'
    more += f'    float3[] primvars:b = {usd_kit.tuples(curve)} (\n        interpolation = "vertex"\n    )\n'
    more += '    int[] primvars:c = [0, 1, 4] (\n        interpolation = "varying"\n    )\n'
    found = read_text(usd_kit.HEAD + usd_kit.prim([curve], basis="bezier", more=more))
    assert found.source.facts["points_a_piece"] == [4]
    off = found.source.facts["off_curves"]
    assert note_of(found.source.facts) == (
        f"curves are cubic bezier; 4 points a piece are taken, whose segments leave them by {off:g} at most"
    )
    want = np.interp(np.arange(9) / 4, [0, 1, 2], [0, 1, 4])
    np.testing.assert_allclose(found.attributes["a"].values, want, rtol=1e-6)
    assert found.attributes["b"].values.tobytes() == found.points.tobytes()
    assert found.source.facts["attributes_not_read"] == ["c"]


def test_curves_of_other_kinds_are_those_that_they_resemble() -> None:
    """NURBS whose knots clamp them reach their ends; those of other orders and Hermite curves are joined straight."""
    curve = np.random.default_rng(8).normal(size=(6, 3)).astype(np.float32)
    nurbs = (
        'def NurbsCurves "n"\n{\n    int[] curveVertexCounts = [6]\n    int[] order = [ORDER]\n'
        "    double[] knots = [KNOTS]\n"
        f"    point3f[] points = {usd_kit.tuples(curve)}\n    double[] pointWeights = [1, 1, 1, 1, 1, WEIGHT]\n}}\n"
    )
    hermite = nurbs.replace("NurbsCurves", "HermiteCurves")

    def made(text: str, order: int = 4, knots: str = "0, 0, 0, 0, 1, 2, 3, 3, 3, 3", weight: int = 1) -> Strands:
        found = text.replace("ORDER", str(order)).replace("KNOTS", knots).replace("WEIGHT", str(weight))
        return read_text(usd_kit.HEAD + found)

    clamped, even = made(nurbs), made(nurbs, knots="0, 1, 2, 3, 4, 5, 6, 7, 8, 9")
    np.testing.assert_allclose(clamped.points, evaluated(curve, Basis("cubic", "bspline", "pinned"), 4), atol=1e-6)
    np.testing.assert_allclose(clamped.points[[0, -1]], curve[[0, -1]], atol=1e-6)
    np.testing.assert_allclose(even.points, evaluated(curve, Basis("cubic", "bspline"), 4), atol=1e-6)
    assert clamped.source.facts["basis"] == even.source.facts["basis"] == ["NURBS"]
    for straight, words in ((made(nurbs, 3), "NURBS of other orders than 4"), (made(hermite), "HermiteCurves")):
        assert straight.points.tobytes() == curve.tobytes()
        assert note_of(straight.source.facts) == f"curves are {words}, joined straight"
    with pytest.raises(UsageError, match="/n: NURBS with weights that differ are not read"):
        made(nurbs, weight=2)


def archive(strands: list[Any], told: tuple[int, int, int], added: Any = (), **arrays: Any) -> Strands:
    """What is read of an object of curves of a type, wrap and basis; ``arrays``: of its geometry, by name."""
    made = Builder()
    kind = made.array("curveBasisAndType", np.array([[*told, told[2]]], "u1"), scalar=True)
    more = [made.array({"orders": ".orders", "knots": ".knots"}.get(name, name), np.asarray(one))
            for name, one in arrays.items()]  # fmt: skip
    more += [made.array(f"a{scope}", one, meta=f"geoScope={scope}") for scope, one in added]
    points = np.concatenate(strands).astype("<f4")
    return read_bytes(made.finish(made.curves("a", points, [len(one) for one in strands], [kind, *more])))


def helix(points: int, radius: float = 0.01) -> Any:
    """A helix of six control points a turn."""
    turn = np.arange(points) * np.pi / 3
    return np.stack([radius * np.cos(turn), -0.002 * turn, radius * np.sin(turn)], axis=1).astype(np.float32)


@pytest.mark.parametrize("basis", list(NAMES))
@pytest.mark.parametrize("periodic", [0, 1])
def test_points_and_values_of_alembic_are_those_of_usd(basis: int, periodic: int) -> None:
    """Of the same control points both readers have the same bits."""
    count = 12 if periodic else 13
    strands = list(np.random.default_rng(basis).normal(size=(3, count, 3)).astype(np.float32))
    pieces = 4 if basis == BEZIER else count if periodic else count - 3
    width = np.random.default_rng(1).random(3 * (pieces + 1 - periodic)).astype(np.float32)
    made = Builder()
    kind = made.array("curveBasisAndType", np.array([[CUBIC, periodic, basis, basis]], "u1"), scalar=True)
    more = [kind, made.array("width", width, meta="geoScope=var")]
    ours = read_bytes(made.finish(made.curves("a", np.concatenate(strands), [count] * 3, more)))
    line = f'    float[] widths = {usd_kit.tuples(width)} (\n        interpolation = "varying"\n    )\n'
    wrap = "periodic" if periodic else "nonperiodic"
    theirs = read_text(usd_kit.HEAD + usd_kit.prim(strands, basis=NAMES[basis], wrap=wrap, more=line))
    assert ours.first.tolist() == theirs.first.tolist()
    assert ours.points.tobytes() == theirs.points.tobytes()
    assert ours.source.facts["basis"] == theirs.source.facts["basis"]
    assert ours.attributes["width"].values.tobytes() == theirs.attributes["width"].values.tobytes()
    joints = ours.attributes["width"].values.reshape(3, -1)[:, ::4]
    np.testing.assert_array_equal(joints[:, : pieces + 1 - periodic], width.reshape(3, -1))


@pytest.mark.parametrize(
    ("told", "arrays", "basis", "like"),
    [((LINEAR, 0, 3), {}, "linear", None), ((VARIABLE, 0, 0), {}, "linear", None),
     ((CUBIC, 0, 0), {}, "cubic without a basis, joined straight", None),
     ((VARIABLE, 0, BSPLINE), {}, "NURBS of other orders than 4, joined straight", None),
     ((VARIABLE, 0, CATMULL_ROM), {}, "cubic catmullRom, pinned", Basis("cubic", "catmullRom", "pinned")),
     ((VARIABLE, 0, BSPLINE), {"orders": np.array([4], "u1"), "w": np.ones(9, "<f4")}, "NURBS",
      Basis("cubic", "bspline")),
     ((CUBIC, 0, BSPLINE), {"knots": np.array([0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 6, 6, 6], "<f4")}, "NURBS",
      Basis("cubic", "bspline", "pinned"))],
)  # fmt: skip
def test_what_other_programs_write_without_a_basis(told: Any, arrays: Any, basis: str, like: Basis | None) -> None:
    found = archive([helix(9)], told, **arrays)
    assert found.source.facts["basis"] == [basis]
    want = helix(9) if like is None else evaluated(helix(9), like, 4)
    np.testing.assert_allclose(found.points, want, atol=1e-8)


@pytest.mark.parametrize(
    ("told", "arrays", "words"),
    [((CUBIC, 0, HERMITE), {}, "cubic curves of the basis hermite are not read"),
     ((CUBIC, 0, 77), {}, "of the basis of number 77"),
     ((CUBIC, 0, BEZIER), {}, "curve 0 has 9 points, which make no whole pieces of cubic bezier"),
     ((VARIABLE, 0, 0), {"w": np.arange(9, dtype="<f4")}, "weights that differ")],
)  # fmt: skip
def test_what_is_not_read_is_told_in_a_line(told: tuple[int, int, int], arrays: dict[str, Any], words: str) -> None:
    with pytest.raises(UsageError) as error:
        archive([helix(9)], told, **arrays)
    assert words in str(error.value)
    assert "\n" not in str(error.value)
