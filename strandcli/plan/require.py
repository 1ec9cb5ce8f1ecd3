"""Refusal of a run that would use more memory than there is, with what to change."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

from ..common.limits import SHARE, available_memory
from ..errors import RefusedError
from .make import Plan, make_plan

if TYPE_CHECKING:
    from ..scene.model import Scene

LEAST_STRANDS, LEAST_SIDE = 10, 16
"""Below which nothing is advised."""


def checked_plan(scene: Scene, frames: Sequence[int], draw: bool = True, check: bool | None = None) -> Plan:
    """Return the plan of a run; raises `RefusedError` where it would take too much of what is free. ``check``: as of
    `require_memory`."""
    plan = make_plan(scene, frames, draw)
    require_memory(plan, scene, frames, draw, check)
    return plan


def require_memory(
    plan: Plan, scene: Scene, frames: Sequence[int], draw: bool = True, check: bool | None = None
) -> None:
    """Raise `RefusedError` if a plan's estimate exceeds `SHARE` of the available memory, with what to change;
    ``check``: whether to look at all, by --no-memory-check; None: the command has no such option."""
    free = None if check is False else available_memory()
    if free is None or plan.memory_bytes <= SHARE * free:
        return
    ways = [*_remedies(scene, frames, draw, SHARE * free)]
    advice = f"take {' or '.join(ways)}" if ways else "draw fewer strands, or a smaller picture"
    regardless = "; --no-memory-check runs it anyway" if check else ""
    raise RefusedError(
        f"this run would take about {_gigabytes(plan.memory_bytes)}, more than {100 * SHARE:.0f} % of the "
        f"{_gigabytes(free)} that are free: {advice}{regardless}"
    )


def _remedies(scene: Scene, frames: Sequence[int], draw: bool, most: float) -> Iterator[str]:
    """Yield changes with which a run takes at most so many bytes, and what it takes then."""
    if scene.panels:
        return
    strands = scene.emitter.strands
    share = _greatest(lambda share: _planned(_with_strands(scene, share), frames, draw), most)
    if share is not None and (fewer := _round(strands * share)) >= LEAST_STRANDS:
        need = _planned(_with_strands(scene, fewer / strands), frames, draw)
        yield f"--strands {fewer} (about {_gigabytes(need)})"
    if not draw:
        return
    width, height = scene.image.size
    share = _greatest(lambda share: _planned(_with_size(scene, share), frames, draw), most)
    if share is not None and min(width, height) * share >= LEAST_SIDE and scene.image.crop is None:
        smaller = _with_size(scene, share)
        need = _planned(smaller, frames, draw)
        yield f"--size {smaller.image.size[0]}x{smaller.image.size[1]} (about {_gigabytes(need)})"


def _greatest(bytes_of: Callable[[float], int], most: float) -> float | None:
    """Return the greatest of some shares of which so few bytes come; None where none is small enough."""
    share = 1.0
    while share > 1e-6:
        share *= 0.8
        if bytes_of(share) <= most:
            return share
    return None


def _planned(scene: Scene, frames: Sequence[int], draw: bool) -> int:
    return make_plan(scene, frames, draw).memory_bytes


def _with_strands(scene: Scene, share: float) -> Scene:
    count = max(1, round(scene.emitter.strands * share))
    return dataclasses.replace(scene, emitter=dataclasses.replace(scene.emitter, strands=count))


def _with_size(scene: Scene, share: float) -> Scene:
    width, height = (max(1, round(side * share)) for side in scene.image.size)
    return dataclasses.replace(scene, image=dataclasses.replace(scene.image, size=(width, height)))


def _round(count: float) -> int:
    """Return a number of two digits and zeros, not above ``count``."""
    unit = 10 ** max(0, math.floor(math.log10(max(count, 1))) - 1)
    return int(count // unit * unit)


def _gigabytes(count: float) -> str:
    return f"{count / 1e9:,.1f} GB" if count >= 1e9 else f"{count / 1e6:,.0f} MB"
