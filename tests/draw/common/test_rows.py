"""Rows of scratch: none serves two quantities at one time, and two that would are refused."""

from __future__ import annotations

import itertools

import pytest

from strandcli.constants import W
from strandcli.draw.common.kernels import batch, layout, soft_rows, surface_batch
from strandcli.draw.common.rows import RowAllocator, RowOverlapError

STAGES = {"strands": ("first", "second", "third"), "surfaces": ("first", "second")}


def test_rows_that_are_never_held_together_are_the_same() -> None:
    rows = RowAllocator(8, STAGES)
    assert rows.allocate("early", 2, strands="first:second") == (0, 8)
    assert rows.allocate_row("late", strands="third") == 0
    assert rows.allocate_row("between", strands="second:third") == 16
    assert rows.allocate_row("of the other", surfaces="first:second") == 0
    assert rows.allocate("neighbours", 2, strands="third", surfaces="second") == (24, 32)
    assert rows.row_count("strands") == 5
    assert rows.holder(0, "strands", "second") == "early"
    assert rows.holder(0, "strands", "third") == "late"
    assert rows.holder(1, "strands", "third") is None


def test_two_quantities_that_live_together_in_one_row_are_refused() -> None:
    rows = RowAllocator(W, STAGES)
    rows.allocate("texels", 4, strands="first:second")
    with pytest.raises(RowOverlapError, match="row 3 would hold radiance beside texels in stage second of strands"):
        rows.allocate_at("radiance", 3, 2, strands="second:third")
    rows.allocate_at("radiance", 3, 2, strands="third")


def test_stages_are_named_in_order() -> None:
    rows = RowAllocator(W, STAGES)
    with pytest.raises(ValueError, match="strands: stage first is before third"):
        rows.allocate_row("backward", strands="third:first")
    with pytest.raises(ValueError, match="strands has no stage fourth"):
        rows.allocate_row("nowhere", strands="fourth")


def test_the_batches_hold_one_quantity_a_row_at_any_time() -> None:
    """By the constants themselves, so that none is aliased beside the allocator."""
    groups = {
        "strands": (vars(batch), vars(soft_rows)),
        "surfaces": (vars(surface_batch), vars(soft_rows)),
    }
    for user, modules in groups.items():
        found = [
            (name, value // W)
            for module in modules
            for name, value in module.items()
            if name.isupper() and isinstance(value, int) and name not in ("ROWS", "CHANNELS", "W")
        ]
        stages = layout.layout._stages[user]
        for (name, row), (other, same) in itertools.combinations(found, 2):
            if row == same:
                held = [{layout.layout.holder(row, user, stage)} - {None} for stage in stages]
                assert len(set().union(*held)) > 1, f"{name} and {other} are one quantity"
    assert layout.layout.row_count("strands") == batch.ROWS
    assert layout.layout.row_count("surfaces") == surface_batch.ROWS
