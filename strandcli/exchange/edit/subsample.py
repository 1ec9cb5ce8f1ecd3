"""Fewer strands: every n-th, a share of them, or so many."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...common.counted import counted
from ..change import Change
from ..repeats import GOLDEN, mixed
from ..strands import CHUNK, Mask, Strands


def every(strands: Strands, step: int) -> tuple[Strands, Change]:
    """Every ``step``-th strand, from the first."""
    keep = np.zeros(strands.count, np.bool_)
    keep[::step] = True
    return _kept(strands, keep, f"every {step}-th", {"every": step})


def share(strands: Strands, part: float, seed: int) -> tuple[Strands, Change]:
    """About a part of the strands. Whether strand i stays depends on the seed and on i alone, and a smaller part is
    held in a larger one."""
    keep = dice(strands.count, seed) < part
    return _kept(strands, keep, f"a share of {part:g}", {"share": part, "seed": seed})


def some(strands: Strands, count: int, seed: int) -> tuple[Strands, Change]:
    """So many strands, those with the lowest dice; fewer are held in more."""
    thrown = dice(strands.count, seed)
    if count < thrown.size:
        last = np.partition(thrown, count)[count]
        keep = thrown < last
        ties = np.flatnonzero(thrown == last)
        keep[ties[: count - np.count_nonzero(keep)]] = True
    else:
        keep = np.ones(strands.count, np.bool_)
    return _kept(strands, keep, f"{count:,} of them", {"strands": count, "seed": seed})


def dice(count: int, seed: int) -> npt.NDArray[np.float64]:
    """A number of [0, 1) for each strand, from the seed and its number alone: SplitMix64 (Steele et al., 2014)."""
    found = np.empty(count)
    with np.errstate(over="ignore"):
        begin = mixed(np.array([seed], np.uint64))
        for low in range(0, count, CHUNK):
            high = min(low + CHUNK, count)
            z = (np.arange(low + 1, high + 1, dtype=np.uint64) + begin) * np.uint64(GOLDEN)
            found[low:high] = (mixed(z) >> np.uint64(11)).astype(np.float64) * 2.0**-53
    return found


def _kept(strands: Strands, keep: Mask, how: str, facts: dict[str, object]) -> tuple[Strands, Change]:
    changed = strands.select(keep)
    text = f"{counted(changed.count, 'strand')} of {strands.count:,} selected, {how}"
    return changed, Change(
        "subsample", text, {**facts, "kept": changed.count, "left_out": strands.count - changed.count}
    )
