"""Edits of strands: what they promise of every groom."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import exchange_kit as kit
from strandcli.common import rotations
from strandcli.exchange import edits, resample
from strandcli.exchange.strands import Attribute, Strands

few = settings(max_examples=40, deadline=None)


def of_each(strands: Strands) -> list[npt.NDArray[np.float32]]:
    return [strands.points[a:b] for a, b in zip(strands.first[:-1], strands.first[1:], strict=True)]


def from_polyline(point: npt.NDArray[np.float64], line: npt.NDArray[np.float64]) -> float:
    """Distance of a point from a polyline: the least of those from its segments."""
    found = []
    for a, b in pairwise(line):
        edge = b - a
        t = np.clip((point - a) @ edge / (edge @ edge), 0, 1) if (edge @ edge) > 0 else 0.0
        found.append(np.linalg.norm(point - a - t * edge))
    return float(min(found))


def deviation(old: Strands, new: Strands) -> float:
    """The largest distance of an old point from the new polyline of its strand."""
    return max(
        from_polyline(point, line.astype(np.float64))
        for points, line in zip(of_each(old), of_each(new), strict=True) for point in points.astype(np.float64)
    )  # fmt: skip


@few
@given(strands=kit.lists_of_strands, count=st.integers(2, 12))
def test_resampled_points_are_at_equal_distances_along(strands: list[kit.Strand], count: int) -> None:
    """numpy.interp over the arc length is the twin."""
    old = kit.of(strands)
    new, change = resample.resampled(old, count)
    for one, other in zip(strands, of_each(new), strict=True):
        along = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(one.astype(np.float64), axis=0), axis=1))])
        places = np.linspace(0, along[-1], count)
        expected = np.stack([np.interp(places, along, one[:, axis].astype(np.float64)) for axis in range(3)], axis=1)
        assert np.abs(other - expected).max() <= 1e-5 * max(1e-3, along[-1])
        assert other[0].tobytes() == one[0].tobytes()
        assert other[-1].tobytes() == one[-1].tobytes()
    size = float(old.lengths().max())
    assert deviation(old, new) <= change.facts["deviation_max"] + 1e-6 * size


def test_attributes_of_points_are_resampled_with_them() -> None:
    strands = kit.of([np.array([[0, 0, 0], [1, 0, 0], [3, 0, 0]], np.float32)])
    attributes = {
        "width": Attribute("point", np.array([0, 1, 3], np.float32)),
        "colour": Attribute("point", np.array([[0, 0, 9], [1, 2, 9], [3, 6, 9]], np.uint8)),
        "root_uv": Attribute("strand", np.array([[1, 2]])),
    }
    new, _ = resample.resampled(Strands(strands.first, strands.points, attributes), 7)
    assert new.attributes["width"].values.tolist() == pytest.approx([0, 0.5, 1, 1.5, 2, 2.5, 3])
    assert new.attributes["colour"].values[-1].tolist() == [3, 6, 9]
    assert new.attributes["root_uv"].values.tolist() == [[1, 2]]


@few
@given(strands=kit.lists_of_strands, share=st.floats(0, 1))
def test_simplified_strands_stay_within_the_tolerance(strands: list[kit.Strand], share: float) -> None:
    old = kit.of(strands)
    tolerance = share * float(old.lengths().mean())
    new, change = resample.simplified(old, tolerance)
    assert deviation(old, new) <= tolerance * (1 + 1e-9)
    assert change.facts["deviation_max"] <= tolerance
    assert (new.counts() >= 2).all()
    assert set(map(bytes, new.points)) <= set(map(bytes, old.points))


def test_a_straight_strand_keeps_its_ends_alone() -> None:
    """And one longer than what is looked at at once a point for each part."""
    x = np.arange(2051, dtype=np.float32)
    straight = np.stack([x, 2 * x, 0 * x], axis=1)
    new, _ = resample.simplified(kit.of([straight[:9], straight]), 1e-6)
    assert [len(one) for one in of_each(new)] == [2, 4]


@pytest.mark.parametrize("up", rotations.AXES)
@pytest.mark.parametrize("to", ["y", "-z"])
def test_turning_takes_one_axis_to_the_other_and_back(up: str, to: str) -> None:
    turn = rotations.turning(up, to)
    assert (turn @ rotations.axis(up) == rotations.axis(to)).all()
    assert np.linalg.det(turn) == pytest.approx(1)
    strands = kit.of([np.random.default_rng(1).normal(size=(9, 3)).astype(np.float32)])
    there = edits.turned(strands, up, to)[0]
    assert edits.turned(there, to, up)[0].points.tobytes() == strands.points.tobytes()


def test_normals_and_widths_follow_a_turn_and_a_factor() -> None:
    strands = kit.of([np.array([[0, 0, 0], [1, 2, 3]], np.float32)])
    attributes = {
        "root_normal": Attribute("strand", np.array([[0.6, 0.8, 0]])), "width": Attribute("groom", np.array([1.0])),
    }  # fmt: skip
    new, _ = edits.scaled(Strands(strands.first, strands.points, attributes), 2.0)
    new, _ = edits.turned(new, "x", "y")
    assert new.points[1].tolist() == [-4, 2, 6]
    assert new.attributes["root_normal"].values.tolist() == [[-0.8, 0.6, 0]]
    assert new.attributes["width"].values.tolist() == [2]


@few
@given(count=st.integers(0, 200), low=st.integers(0, 200), high=st.integers(0, 200), seed=st.integers(0, 9))
def test_few_strands_are_among_more(count: int, low: int, high: int, seed: int) -> None:
    strands = kit.of([np.full((2, 3), i, np.float32) for i in range(count)])
    few_of, more_of = (resample.some(strands, many, seed)[0] for many in sorted((low, high)))
    assert few_of.count == min(low, high, count)
    assert set(few_of.points[::2, 0].tolist()) <= set(more_of.points[::2, 0].tolist())


def test_lengths_are_bounds() -> None:
    strands = kit.of([np.array([[0, 0, 0], [x, 0, 0]], np.float32) for x in range(5)])
    new, change = resample.between(strands, 1, 3)
    assert new.points[1::2, 0].tolist() == [1, 2, 3]
    assert (change.facts["too_short"], change.facts["too_long"]) == (1, 1)


def head(seed: int = 1, count: int = 200) -> npt.NDArray[np.float32]:
    """Strands (count, 20, 3) that leave the upper half of a head of radius 9 and hang, outside it."""
    generator = np.random.default_rng(seed)
    out = generator.normal(size=(count, 1, 3))
    out[..., 1] = np.abs(out[..., 1])
    out /= np.linalg.norm(out, axis=2, keepdims=True)
    t = np.linspace(0, 1, 20)[:, None]
    length = generator.uniform(10, 30, (count, 1, 1))
    found = 9 * out + 4 * t * out + length * t**2.5 * np.array([0, -1, 0])
    return (found * np.maximum(1, 9 / np.linalg.norm(found, axis=2, keepdims=True))).astype(np.float32)


def test_fixing_leaves_out_and_turns_around() -> None:
    groom = list(head())
    bad = groom[0].copy()
    bad[3, 1] = np.nan
    strands = kit.of([*groom, bad, groom[5], np.zeros((4, 3), np.float32), groom[9].copy()])
    odd = {"weight": Attribute("strand", np.where(np.arange(204) == 3, np.nan, 1.0).astype(np.float32))}
    new, change = edits.fixed(Strands(strands.first, strands.points, odd))
    assert change.facts == {
        "not_finite": 1, "without_length": 1, "repeated": 2, "attributes_left_out": ["weight"], "turned_around": 0,
    }  # fmt: skip
    assert new.points.tobytes() == head().tobytes()
    assert change.text == (
        "mended: 1 strand not finite, left out; 1 strand without length, left out; 2 strands equal to another, "
        "left out; weight not finite, left out"
    )
    again, change = edits.fixed(new)
    assert again.points.tobytes() == new.points.tobytes()
    assert change.text == "mended: nothing, no fault was found"


@pytest.mark.parametrize("mend", [edits.fixed, edits.reversed_all])
def test_grooms_that_begin_at_the_tips_are_turned_around(mend: Any) -> None:
    strands = kit.of(list(head()[:, ::-1]))
    assert mend(strands)[0].points.tobytes() == head().tobytes()


def test_no_strands_are_no_fault() -> None:
    none = kit.of([])
    for edit in (
        edits.fixed, edits.reversed_all, lambda one: edits.scaled(one, 2.0), lambda one: resample.between(one, 0, 1),
        lambda one: resample.some(one, 5, 0),
        lambda one: resample.resampled(one, 5), lambda one: resample.simplified(one, 1.0),
    ):  # fmt: skip
        assert edit(none)[0].count == 0
