"""Warnings about settings of drawing that are probably not intended."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from ..scene.motion import camera_at, emitter_pose
from ..scene.named_files import files_of

if TYPE_CHECKING:
    from ..scene.model import Scene

THIN = 0.7
"""Width of a root on the screen, in samples, below which the z-buffer's lines are visibly too wide."""


def warnings_of(scene: Scene, frames: Sequence[int]) -> Iterator[str]:
    """Yield warnings, a line each, for some frames."""
    yield from _lines_too_wide(scene, frames)
    pictures = [(key, path) for key, path, kind in files_of(scene) if kind == "picture"]
    if pictures:
        from ..files.picture_samples import is_transparent  # NumPy comes with it

        for key, path in pictures:
            if is_transparent(path):
                yield f"{key}: {path}: its alpha is ignored; save it without, over the colour that is meant"


def _lines_too_wide(scene: Scene, frames: Sequence[int]) -> Iterator[str]:
    width = scene.material.width
    if width == 0 or scene.image.resolver != "zbuffer" or scene.look == "source" or not frames:
        return
    seen = width * samples_a_metre(scene, (frames[0] - 1) / scene.time.fps)
    if seen < THIN:
        yield (
            f"strands {1000 * width:g} mm wide are {seen:.2g} pixels wide here, and image.resolver zbuffer draws hard "
            "lines of one pixel: add --quality default, or set image.resolver=sorted; look: source requires the lines"
        )


def samples_a_metre(scene: Scene, time: float) -> float:
    """Return the number of samples of a metre at the emitter on the screen, at a time."""
    camera = scene.camera
    view = camera_at(camera, time)
    samples = scene.image.size[1] * scene.image.supersample
    if camera.kind == "orthographic":
        return samples / view.height
    away = math.dist(view.position, emitter_pose(scene.emitter, time).translation)
    return samples / 2 / math.tan(math.radians(view.fov) / 2) / max(away, camera.near)


def labelled(parts: Iterable[tuple[str, Iterable[str]]]) -> list[str]:
    """The warnings of panels, each once, behind the labels of those that it is of; a single scene's label is ""."""
    labels: dict[str, list[str]] = {}
    for label, found in parts:
        for words in found:
            labels.setdefault(words, []).append(label)
    return [f"{', '.join(filter(None, names))}: {words}" if any(names) else words for words, names in labels.items()]
