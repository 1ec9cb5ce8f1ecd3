"""Frame ranges: what is written is what is meant, and nothing that cannot be meant gets through."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from strandcli.cli.values import FrameRange
from strandcli.errors import UsageError

parts = st.tuples(st.integers(1, 500), st.integers(0, 60), st.integers(1, 80)).map(lambda p: (p[0], p[0] + p[1], p[2]))


@given(st.lists(parts, min_size=1, max_size=6))
def test_the_numbers_are_those_of_every_part_once_and_in_order(written: list[tuple[int, int, int]]) -> None:
    text = ",".join(f"{first}-{last}x{step}" for first, last, step in written)
    expected = [number for first, last, step in written for number in range(first, last + 1, step)]
    found = FrameRange.parse(text)
    assert list(found.numbers()) == sorted(set(expected))
    assert found.last == max(expected)


@given(st.text(max_size=20))
def test_any_text_is_either_frames_from_1_or_a_value_error(text: str) -> None:
    try:
        found = FrameRange.parse(text)
    except ValueError:
        return
    assert all(character in "0123456789-x," or character.isspace() for character in text)
    assert all(part[0] >= 1 for part in found.parts)


@pytest.mark.parametrize("text", ["", "0", "5-3", "1-", "1-5x0", "1.5", "１", "1-9999999999999999999"])
def test_what_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"frame|runs backwards|step"):
        FrameRange.parse(text)


def test_a_huge_range_costs_nothing_until_it_is_known_to_fit() -> None:
    huge = FrameRange.parse("1-9999999")
    with pytest.raises(UsageError, match="asks for frame 9999999, but the animation has frames 1 to 48"):
        huge.within(48)
    with pytest.raises(UsageError, match="asks for frame 9999999999, but"):
        FrameRange.parse("1-9999999999").within(48)
    assert FrameRange.parse("1-48").within(48) == tuple(range(1, 49))
