"""Arrays that are reused from frame to frame."""

from __future__ import annotations

import mmap
import weakref
from pathlib import Path

import numpy as np
import pytest

from strandcli.draw.common.scratch import LINE, Scratch


def test_a_borrowed_array_is_the_same_memory_until_a_larger_one_is_asked_for() -> None:
    scratch = Scratch()
    for borrow in (scratch.borrow, scratch.sparse):
        first = borrow("a", 1000, np.float32)
        first[:] = 7
        assert (borrow("a", 900, np.float32) == 7).all()
        assert borrow("a", 5000, np.float32).shape == (5000,)
        assert borrow("a", 10, np.uint64).dtype == np.uint64
        assert borrow("b", 0, np.uint64).shape == (0,)


def test_arrays_that_are_released_share_memory_in_turns() -> None:
    scratch = Scratch()
    scratch.release("a", "b", "small")
    first = scratch.borrow("a", 1000, np.float32)
    assert first.ctypes.data % LINE == 0
    assert not np.shares_memory(scratch.borrow("b", 1000, np.float32), first)  # both are in use
    scratch.release("a")
    assert not np.shares_memory(scratch.borrow("c", 1000, np.float32), first)  # never released, it keeps its own
    assert not np.shares_memory(scratch.borrow("small", 10, np.float32), first)  # most would be left over
    scratch.release("b")
    scratch.borrow("b", 900, np.int32)
    scratch.release("c")
    assert np.shares_memory(scratch.borrow("a", 900, np.float32), first)  # the one that had it before others


def test_what_no_array_is_in_is_given_back() -> None:
    scratch = Scratch()
    held, left = scratch.borrow("held", 1000, np.float32), scratch.borrow("left", 5000, np.float32)
    gone = weakref.ref(left.base)
    del left
    scratch.release("left")
    assert gone() is not None
    scratch.let_go()
    assert gone() is None
    assert np.shares_memory(scratch.borrow("held", 1000, np.float32), held)


@pytest.mark.skipif(not hasattr(mmap, "MADV_NOHUGEPAGE"), reason="no huge pages")
def test_of_a_sparse_array_only_what_is_written_to_takes_memory() -> None:
    def resident() -> int:
        return int(Path("/proc/self/statm").read_text().split()[1]) * mmap.PAGESIZE

    array = Scratch().sparse("a", 16_000_000, np.uint32)
    assert array.flags.c_contiguous
    assert array.flags.writeable
    before = resident()
    array[:: 1 << 17] = 1  # a page in each half of a megabyte
    assert resident() - before < 8_000_000
