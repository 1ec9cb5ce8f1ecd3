"""Curves of Alembic that are not straight: the points that strands get of them, beside those of USD and of de Boor."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import usd_kit
from abc_kit import Builder
from strandcli.errors import UsageError
from strandcli.exchange.control import note_of
from strandcli.exchange.files import ReadOptions, moments_of, read, write
from strandcli.exchange.strands import Strands
from tests.exchange.test_abc import read_bytes
from tests.exchange.test_usd import read_text

BEZIER, BSPLINE, CATMULL_ROM, HERMITE, POWER = range(1, 6)
NAMES = {BEZIER: "bezier", BSPLINE: "bspline", CATMULL_ROM: "catmullRom", HERMITE: "hermite"}
CUBIC, LINEAR, VARIABLE = range(3)


def curves(made: Builder, strands: list[Any], told: tuple[int, int, int], more: Any = (), name: str = "a") -> Any:
    """An object of curves of a type, wrap and basis."""
    kind = made.array("curveBasisAndType", np.array([[*told, told[2]]], "u1"), scalar=True)
    points = np.concatenate(strands).astype("<f4")
    return made.curves(name, points, [len(one) for one in strands], [kind, *more])


def archive(strands: list[Any], told: tuple[int, int, int], **arrays: Any) -> Strands:
    """What is read of one object; ``arrays``: of its geometry, by name."""
    made = Builder()
    more = [made.array({"orders": ".orders", "knots": ".knots"}.get(name, name), np.asarray(one))
            for name, one in arrays.items()]  # fmt: skip
    return read_bytes(made.finish(curves(made, strands, told, more)))


def helix(points: int, radius: float = 0.01) -> Any:
    """A helix of six control points a turn."""
    turn = np.arange(points) * np.pi / 3
    return np.stack([radius * np.cos(turn), -0.002 * turn, radius * np.sin(turn)], axis=1).astype(np.float32)


@pytest.mark.parametrize("basis", list(NAMES))
@pytest.mark.parametrize("periodic", [0, 1])
def test_points_and_values_are_those_of_usd(basis: int, periodic: int) -> None:
    """Of the same control points both readers have the same bits, with values of every scope."""
    count = 12 if periodic or basis == HERMITE else 13
    generator = np.random.default_rng(basis)
    strands = [generator.normal(size=(count, 3)).astype(np.float32) for _ in range(3)]
    pieces = {BEZIER: 4, HERMITE: 5 + periodic}.get(basis, count if periodic else count - 3)
    sizes = {"con": 1, "uni": 3, "var": 3 * (pieces + 1 - periodic), "vtx": 3 * count}
    kinds = {"con": "constant", "uni": "uniform", "var": "varying", "vtx": "vertex"}
    values = {scope: generator.random(size).astype(np.float32) for scope, size in sizes.items()}
    made = Builder()
    added = [made.array(f"a{scope}", one, meta=f"geoScope={scope}") for scope, one in values.items()]
    more = [made.array("width", values["var"], meta="geoScope=var"), made.compound(".arbGeomParams", added)]
    ours = read_bytes(made.finish(curves(made, strands, (CUBIC, periodic, basis), more)))
    told = {**{f"primvars:a{scope}": (one, kinds[scope]) for scope, one in values.items()},
            "widths": (values["var"], "varying")}  # fmt: skip
    lines = [f'    float[] {name} = {usd_kit.tuples(one)} (\n        interpolation = "{kind}"\n    )\n'
             for name, (one, kind) in told.items()]  # fmt: skip
    wrap = "periodic" if periodic else "nonperiodic"
    theirs = read_text(usd_kit.HEAD + usd_kit.prim(strands, basis=NAMES[basis], wrap=wrap, more="".join(lines)))
    assert ours.first.tolist() == theirs.first.tolist()
    assert ours.points.tobytes() == theirs.points.tobytes()
    assert ours.source.facts["basis"] == theirs.source.facts["basis"]
    assert ours.attributes.keys() == theirs.attributes.keys() == {"width", "acon", "auni", "avar", "avtx"}
    for name, one in ours.attributes.items():
        assert one.domain == theirs.attributes[name].domain
        assert one.values.tobytes() == theirs.attributes[name].values.tobytes(), name
    joints = np.flatnonzero(np.arange(ours.points.shape[0] // 3) % ours.source.facts["points_a_piece"][0] == 0)
    width = ours.attributes["width"].values.reshape(3, -1)[:, joints]
    np.testing.assert_array_equal(width[:, : pieces + 1 - periodic], values["var"].reshape(3, -1))


def de_boor(control: Any, knots: Any, order: int, t: float) -> Any:
    """The point of a B-spline at t, by the recursion of its basis functions from steps."""

    def step(i: int, degree: int) -> float:
        if degree == 0:
            return float(knots[i] <= t < knots[i + 1])
        found = 0.0
        if knots[i + degree] > knots[i]:
            found += (t - knots[i]) / (knots[i + degree] - knots[i]) * step(i, degree - 1)
        if knots[i + degree + 1] > knots[i + 1]:
            found += (knots[i + degree + 1] - t) / (knots[i + degree + 1] - knots[i + 1]) * step(i + 1, degree - 1)
        return found

    return sum(step(i, order - 1) * point for i, point in enumerate(control.astype(np.float64)))


@settings(max_examples=20, deadline=None)
@given(
    orders=st.lists(st.integers(2, 4), min_size=1, max_size=2), seed=st.integers(0, 999), clamped=st.booleans(),
    repeated=st.booleans(),
)  # fmt: skip
def test_nurbs_are_sums_of_their_basis_functions(orders: list[int], seed: int, clamped: bool, repeated: bool) -> None:
    orders = [*orders, 4]  # so that not all are polygons
    generator = np.random.default_rng(seed)
    strands, knots = [], []
    for order in orders:
        count = int(generator.integers(order, order + 5))
        strands.append(generator.normal(size=(count, 3)).astype(np.float32))
        rising = np.cumsum(generator.integers(1, 4, count + order)).astype(np.float64)
        if clamped:
            rising[:order], rising[count:] = rising[order - 1], rising[count]
        if repeated and count > order:
            rising[order] = rising[order - 1] if order > 2 else rising[order]
        knots.append(rising)
    found = archive(strands, (VARIABLE, 0, 0), orders=np.array(orders, "u1"), knots=np.concatenate(knots).astype("<f4"))
    assert found.source.facts["basis"] == ["NURBS"]
    each = found.source.facts["points_a_piece"][0]
    for i, (order, control, own) in enumerate(zip(orders, strands, knots, strict=True)):
        joints = np.unique(own[order - 1 : len(control) + 1])
        places = np.interp(np.arange((len(joints) - 1) * each + 1) / each, np.arange(len(joints)), joints)
        points = found.points[found.first[i] : found.first[i + 1]]
        assert len(points) == len(places)
        want = [de_boor(control, own, order, t) for t in places[:-1]]
        np.testing.assert_allclose(points[:-1], want, rtol=1e-4, atol=1e-5)
        if clamped and not repeated:
            np.testing.assert_allclose(points[[0, -1]], control[[0, -1]], atol=1e-6)


def test_knots_that_are_uniform_change_nothing_and_clamped_ones_reach_the_ends() -> None:
    plain = archive([helix(9)], (CUBIC, 0, BSPLINE))
    told = archive([helix(9)], (CUBIC, 0, BSPLINE), knots=np.arange(13, dtype="<f4"))
    joints = [one.points[:: one.source.facts["points_a_piece"][0]] for one in (told, plain)]
    np.testing.assert_allclose(*joints, atol=1e-8)
    blender = archive([helix(9)], (VARIABLE, 0, BSPLINE), orders=np.array([4], "u1"), w=np.ones(9, "<f4"))
    assert blender.points.tobytes() == plain.points.tobytes()
    smooth = archive([helix(9)], (VARIABLE, 0, CATMULL_ROM))
    assert smooth.source.facts["basis"] == ["cubic catmullRom, pinned"]
    np.testing.assert_allclose(smooth.points[:: smooth.source.facts["points_a_piece"][0]], helix(9), atol=1e-8)


@pytest.mark.parametrize(
    ("told", "basis"),
    [((LINEAR, 0, 3), "linear"), ((VARIABLE, 0, 0), "linear"),
     ((CUBIC, 0, 0), "cubic without a basis, joined straight"),
     ((VARIABLE, 0, BSPLINE), "bspline of no orders, joined straight")],
)  # fmt: skip
def test_what_has_no_basis_is_joined_straight_and_said(told: tuple[int, int, int], basis: str) -> None:
    found = archive([helix(9)], told)
    assert found.source.facts["basis"] == [basis]
    assert found.points.tobytes() == helix(9).tobytes()
    assert note_of(found.source.facts) == (None if basis == "linear" else f"curves are {basis}")


@pytest.mark.parametrize(
    ("told", "arrays", "words"),
    [((CUBIC, 0, POWER), {}, "cubic curves of the basis power are not read"),
     ((CUBIC, 0, 77), {}, "of the basis of number 77"),
     ((CUBIC, 0, BEZIER), {}, "curve 0 has 9 points, which make no whole pieces of cubic bezier"),
     ((VARIABLE, 0, BSPLINE), {"orders": np.array([6], "u1"), "knots": np.zeros(15, "<f4")}, "there are some of 6"),
     ((VARIABLE, 0, BSPLINE), {"orders": np.array([3], "u1"), "knots": np.zeros(9, "<f4")}, "9 knots, 12 are needed"),
     ((VARIABLE, 0, BSPLINE), {"orders": np.array([3, 3], "u1")}, "2 orders for 1 curve"),
     ((VARIABLE, 1, BSPLINE), {"orders": np.array([3], "u1")}, "periodic NURBS without knots"),
     ((VARIABLE, 0, 0), {"orders": np.array([3], "u1"), "knots": -np.arange(12, dtype="<f4")}, "do not rise"),
     ((VARIABLE, 0, 0), {"orders": np.array([3], "u1"), "w": np.arange(9, dtype="<f4")}, "weights that differ")],
)  # fmt: skip
def test_what_is_not_read_is_told_in_a_line(told: tuple[int, int, int], arrays: dict[str, Any], words: str) -> None:
    with pytest.raises(UsageError) as error:
        archive([helix(9)], told, **arrays)
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_curves_that_move_are_evaluated_at_each_time_and_written() -> None:
    """A transform moves them too; Hermite curves have tangents, which it does not shift."""
    generator = np.random.default_rng(8)
    for basis in NAMES:
        made = Builder()
        stored = [generator.normal(size=(10, 3)).astype("<f4") for _ in range(3)]
        kind = made.array("curveBasisAndType", np.array([[CUBIC, 0, basis, basis]], "u1"), scalar=True)
        told = [made.array("P", *stored), made.array("nVertices", np.array([10], "<i4")), kind]
        shape = made.object("c", "schema=AbcGeom_Curve_v2", [made.compound(".geom", told)])
        content = made.finish(made.xform("x", [1], [[1.0, 2.0, 3.0]], [shape]))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "a.abc")
            path.write_bytes(content)
            still = read(path)
            seen = list(moments_of(path, ReadOptions(), (1, 2, 3)))
            assert seen[0].points.tobytes() == still.points.tobytes()
            write(Path(folder, "b.abc"), still, seen)
            again = list(moments_of(Path(folder, "b.abc"), ReadOptions(), (1, 2, 3)))
        assert [one.points.tobytes() for one in again] == [one.points.tobytes() for one in seen]
        each = still.source.facts["points_a_piece"][0]
        corners = {BEZIER: slice(0, None, 3), CATMULL_ROM: slice(1, -1), HERMITE: slice(0, None, 2)}.get(basis)
        if corners is not None:
            for control, one in zip(stored, seen, strict=True):
                np.testing.assert_allclose(one.points[::each], control[corners] + [1, 2, 3], atol=1e-6)
