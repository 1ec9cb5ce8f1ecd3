"""The plan of a scene: its stages, its cost, its memory; and refusal of a run that needs more memory than there is."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ..common.limits import SHARE, available_memory
from ..errors import RefusedError
from ..scene.detail import needed_strands
from ..scene.named_files import naming_files
from .decisions import Stage, drawing_decisions, labelled, motion_decisions, solver_steps, warnings_of
from .memory import memory_of, picture_bytes, program_bytes, shared_bytes
from .sizes import Sizes, most_strands, points_of, sizes_of

if TYPE_CHECKING:
    from ..scene.model import Scene


THREAD = 10_000_000
"""Bytes of a thread with a renderer of its own, besides its picture."""
LEAST_STRANDS, LEAST_SIDE = 10, 16
"""Below which nothing is advised."""


@dataclass
class Plan:
    """The stages of a run of some frames of a scene, and its cost."""

    used: list[Stage] = field(default_factory=list)
    left_out: list[Stage] = field(default_factory=list)
    strands: int = 0
    """Number of simulated strands: the greatest that any frame needs."""
    particles: int = 0
    steps: int = 0
    """Solver steps, including those of the pre-roll and of frames that are not drawn."""
    frames: int = 0
    segments_max: int = 0
    """Greatest number of line pieces in a frame."""
    pixels: int = 0
    samples: int = 0
    sizes: Sizes | None = None
    """Estimated sizes of the largest frame; None where nothing is drawn, and of panels."""
    of_file: bool = False
    """Whether the strands are those of a file."""
    memory_bytes: int = 0
    """Estimated peak of the process, where frames are drawn one by one."""
    frames_at_once: int = 1
    """That are drawn side by side, if there are as many threads and the frame's stages are as usual."""
    memory_at_once_bytes: int = 0
    """Estimated peak of the process then."""
    parts: list[Plan] = field(default_factory=list)
    """Those of the panels, where there are any."""
    warnings: list[str] = field(default_factory=list)
    """Settings that are probably not intended, one line each."""

    def add(self, decisions: Iterable[Stage]) -> None:
        """Add stages that run or are left out."""
        for one in decisions:
            (self.used if one.runs else self.left_out).append(one)


def make_plan(scene: Scene, frames: Sequence[int], draw: bool = True, threads: int = 1) -> Plan:
    """Return the plan for some frames, numbered from 1; that of panels is their sum. ``threads``: that draw."""
    if scene.panels:
        return _of_panels(scene, frames, draw)
    with naming_files(scene):
        plan = _of_scene(scene, frames, draw)
        if draw and threads > 1 and plan.frames > 2:  # after the first ones
            plan.frames_at_once = min(threads, plan.frames - 2, _fitting(plan, scene))
        more = plan.frames_at_once - 1
        plan.memory_at_once_bytes = plan.memory_bytes + (more * _each_more(plan, scene) if more else 0)
    return plan


def _of_scene(scene: Scene, frames: Sequence[int], draw: bool) -> Plan:
    plan = Plan(frames=len(frames), of_file=scene.emitter.groom is not None)
    plan.strands = needed_strands(scene, frames) if draw else scene.emitter.strands
    plan.particles = plan.strands * scene.emitter.particles
    plan.steps = solver_steps(scene, frames)
    plan.add(motion_decisions(scene, plan.strands))
    if draw:
        plan.sizes = sizes_of(scene, plan.strands, frames)
        pieces = 1 if scene.curves.mode in ("off", "thinned") else 2**scene.curves.level
        plan.segments_max = most_strands(scene, plan.strands, ()) * (points_of(scene) - 1) * pieces
        plan.pixels = math.prod(scene.image.drawn)
        plan.samples = plan.pixels * scene.image.supersample**2
        plan.add(drawing_decisions(scene, plan.strands, frames))
        plan.warnings += warnings_of(scene, frames)
    plan.memory_bytes = memory_of(plan, scene, draw)
    return plan


def _of_panels(scene: Scene, frames: Sequence[int], draw: bool) -> Plan:
    parts = [make_plan(panel, frames, draw) for panel in scene.panels]
    plan = Plan(frames=len(frames), parts=parts)
    for panel, part in zip(scene.panels, parts, strict=True):
        name = panel.label or "panel"
        plan.add(one._replace(stage=f"{name}: {one.stage}") for one in (*part.used, *part.left_out))
        for total in ("strands", "particles", "steps", "segments_max", "pixels", "samples"):
            setattr(plan, total, getattr(plan, total) + getattr(part, total))
    plan.warnings = labelled((panel.label, part.warnings) for panel, part in zip(scene.panels, parts, strict=True))
    programs = [program_bytes(panel, draw) for panel in scene.panels]
    own = sum(part.memory_bytes - program for part, program in zip(parts, programs, strict=True))
    plan.memory_bytes = max(programs) + own
    plan.memory_at_once_bytes = plan.memory_bytes
    return plan


def pictures_that_fit(scene: Scene, frames: Sequence[int]) -> int:
    """Return how many frames may be drawn at once: several may at most double the memory of the run and use half of the
    available memory."""
    return _fitting(make_plan(scene, frames), scene)


def _fitting(plan: Plan, scene: Scene) -> int:
    """As `pictures_that_fit`, for a plan."""
    free, spare = available_memory(), plan.memory_bytes
    if free is not None:
        spare = min(spare, free // 2, max(0, int(SHARE * free) - plan.memory_bytes))
    return 1 + spare // _each_more(plan, scene)


def _each_more(plan: Plan, scene: Scene) -> int:
    """Return the bytes of each further frame that is drawn at once, with its thread and its copy of the state."""
    state = plan.strands * 12 * (scene.emitter.particles + 1)
    return picture_bytes(plan, scene) - shared_bytes(plan, scene) + state + THREAD


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
    remedies = [*_remedies(scene, frames, draw, SHARE * free)]
    advice = f"take {' or '.join(remedies)}" if remedies else "draw fewer strands, or a smaller picture"
    regardless = "; --no-memory-check runs it anyway" if check else ""
    raise RefusedError(
        f"this run would take about {_gigabytes(plan.memory_bytes)}, more than {100 * SHARE:.0f} % of the "
        f"{_gigabytes(free)} that are free: {advice}{regardless}"
    )


def _remedies(scene: Scene, frames: Sequence[int], draw: bool, most: float) -> Iterator[str]:
    """Yield changes with which a run takes at most so many bytes, and what it takes then."""
    if scene.panels:
        return

    def planned(scene: Scene) -> int:
        return make_plan(scene, frames, draw).memory_bytes

    def greatest(changed: Callable[[Scene, float], Scene]) -> float:
        """The greatest of some shares with which it fits; 0 where none is small enough."""
        shares = (0.8**power for power in range(1, 62))
        return next((share for share in shares if planned(changed(scene, share)) <= most), 0.0)

    strands = scene.emitter.strands
    if (fewer := _round(strands * greatest(_with_strands))) >= LEAST_STRANDS:
        yield f"--strands {fewer} (about {_gigabytes(planned(_with_strands(scene, fewer / strands)))})"
    if draw and scene.image.crop is None:
        smaller = _with_size(scene, greatest(_with_size))
        width, height = smaller.image.size
        if min(width, height) >= LEAST_SIDE:
            yield f"--size {width}x{height} (about {_gigabytes(planned(smaller))})"


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
