"""Simulated positions, as commands write and take them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import UsageError

if TYPE_CHECKING:
    from ..output.positions import Motion, PositionCache
    from ..scene.model import Scene


def motion_of(scene: Scene) -> Motion:
    """What positions of a scene follow from."""
    from ..output.positions import Motion
    from ..run.fingerprint import motion_fingerprint, motion_values

    values = motion_values(scene)
    return Motion(motion_fingerprint(values), values)


def open_cache(
    directory: Path | None, frames: tuple[int, ...], scene: Scene, keep_going: bool = False
) -> PositionCache | None:
    """The checked folder of --from-cache; with ``keep_going`` its positions need not be finite. Raises `UsageError`
    where strands of the scene move otherwise."""
    if directory is None:
        return None
    from ..output.positions import PositionCache
    from ..run.fingerprint import difference

    if scene.panels:
        raise UsageError("--from-cache: a preset of several panels has several sets of positions; draw it without")
    if scene.camera.shutter > 0:  # what moves is drawn between two frames
        frames = tuple(sorted({*frames, *(frame - 1 for frame in frames if frame > 1)}))
    cache = PositionCache(directory, frames, scene.emitter.strands, scene.emitter.particles, finite=not keep_going)
    if cache.motion is not None:
        differs = difference(motion_of(scene).settings, cache.motion.settings)
        if differs:
            raise UsageError(
                f"{directory}: was simulated with another {differs.removesuffix('.')}, which moves strands otherwise; "
                "simulate it anew, or give the preset and the options that it was simulated with"
            )
    return cache


def other_motion(cache: PositionCache, scene: Scene) -> list[str]:
    """What frames drawn from positions depend on beside the scene: nothing where it would simulate the very same."""
    if cache.motion is None:
        return [str(cache.directory.resolve()), cache.digest]
    return [] if cache.motion.fingerprint == motion_of(scene).fingerprint else [cache.motion.fingerprint]
