"""Bounding boxes of strands, of those that fade, and of parts of them."""

from __future__ import annotations

import numpy as np
import pytest

from strandcli.constants import W
from strandcli.draw.geometry.extent import bounds_of, boxes_of
from strandcli.draw.geometry.kernels.boxes import GROUP, GROUPS, PART


@pytest.mark.parametrize("most", [1.0, 0.5])
@pytest.mark.parametrize("fading", [0, 70])
def test_strands_that_fade_extend_the_box_in_proportion(most: float, fading: int) -> None:
    """Against a sum over strands, one by one; the rest of the last block does not count."""
    rng = np.random.default_rng(fading)
    blocks, strands = 3, 2 * W + 40
    positions = rng.normal(size=(blocks, 5, 3, W)).astype(np.float32)
    positions[-1, ..., 40:] = 100
    fade = np.full(strands, most, np.float32)
    fade[:fading] = rng.uniform(0.01, 0.49, fading)
    fade[fading : fading + 60] = 0
    each = positions[:, 1:].transpose(0, 3, 1, 2).reshape(-1, 4, 3)[:strands].astype(np.float64)
    whole = fade == most
    box = np.stack([each[whole].min((0, 1)), each[whole].max((0, 1))])
    expected = box.copy()
    for points, share in zip(each, fade, strict=True):
        expected[0] = np.minimum(expected[0], box[0] + np.minimum((points - box[0]) * float(share), 0).min(0))
        expected[1] = np.maximum(expected[1], box[1] + np.maximum((points - box[1]) * float(share), 0).max(0))
    found = bounds_of(positions.reshape(blocks, 5, 3 * W), strands, fade)
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    assert (found[0] < box[0]).any() == (fading > 0)


@pytest.mark.parametrize("rows", [2, 3, 2 + PART, 3 + PART])
def test_boxes_are_those_of_the_strands_and_rows_that_count(rows: int) -> None:
    """Neither the row before the root nor the rest of the last block does; a segment has both its ends."""
    rng = np.random.default_rng(rows)
    blocks, strands = 2, W + 40
    positions = rng.normal(size=(blocks, rows, 3, W)).astype(np.float32)
    positions[-1, ..., 40:] = 100
    positions[:, 0] = 200
    each = positions[:, 1:].transpose(0, 3, 1, 2).reshape(-1, rows - 1, 3)[:strands]
    found = boxes_of(positions.reshape(blocks, rows, 3 * W), strands)
    np.testing.assert_array_equal(
        bounds_of(positions.reshape(blocks, rows, 3 * W), strands), [each.min((0, 1)), each.max((0, 1))]
    )
    for block in range(blocks):
        for at, box in enumerate(found[block, :-1]):
            part, group = divmod(at, GROUPS)
            first = block * W + group * GROUP
            own = each[first : min(first + GROUP, (block + 1) * W), part * PART : (part + 1) * PART + 1]
            if own.size:
                np.testing.assert_array_equal(box, [*own.min((0, 1)), *own.max((0, 1))])
            else:
                assert (box[:3] > box[3:]).all()
