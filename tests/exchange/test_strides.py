"""How many points each strand has, where a file does not say so."""

from __future__ import annotations

import numpy as np
import pytest

import exchange_kit as kit
from strandcli.errors import UsageError
from strandcli.exchange.files import ReadOptions
from tests.exchange.test_formats import EQUAL, check, read_bytes


def test_vertices_alone_ask_for_the_stride() -> None:
    content = kit.ply(EQUAL, told="nothing")
    with pytest.raises(UsageError, match=r"12 of them, .*--stride N \(they divide into strands of 2, 3, 4, 6, 12\)"):
        read_bytes(content, ".ply")
    check(read_bytes(content, ".ply", ReadOptions(stride=4)), EQUAL)
    with pytest.raises(UsageError, match="5 does not divide them"):
        read_bytes(content, ".ply", ReadOptions(stride=5))


def test_jumps_that_leave_no_doubt_tell_the_stride() -> None:
    """Of curls on a scalp, and of no others: points scattered at random have no stride."""
    generator = np.random.default_rng(3)
    t = np.linspace(0, 1, 100)
    roots = generator.normal(size=(50, 1, 3))
    curls = roots + np.stack([0.1 * np.cos(9 * t), -t, 0.1 * np.sin(9 * t)], axis=1)
    found = read_bytes(kit.ply(list(curls.astype(np.float32)), told="nothing"), ".ply")
    assert found.source.facts["stride_guessed"] == 100
    check(found, list(curls.astype(np.float32)))
    with pytest.raises(UsageError, match="--stride"):
        read_bytes(kit.ply(list(generator.normal(size=(50, 100, 3)).astype(np.float32)), told="nothing"), ".ply")


@pytest.mark.filterwarnings("error")
def test_numbers_that_are_not_finite_have_no_stride_and_no_warning() -> None:
    """Signalling NaN too, which warn where they are cast."""
    content = kit.ply(EQUAL, told="nothing")
    begin = content.index(b"end_header") + len("end_header\n")
    content = content[:begin] + b"\x01\x00\x80\x7f\x00\x00\x80\x7f" + content[begin + 8 :]
    with pytest.raises(UsageError, match="--stride"):
        read_bytes(content, ".ply", ReadOptions(lenient=True))
