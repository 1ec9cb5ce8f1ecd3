"""A scene with what it takes from its file of strands: how many, how long, how wide, and where the camera stands."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..exchange.moments import USUAL
from ..scene.model import Extent
from .following import DENSE, with_followers
from .measure import fitted, some_of, width_for
from .read import from_scene

if TYPE_CHECKING:
    from ..exchange.moments import Moments
    from ..scene.model import Scene
    from ..scene.model.scene import Time

MOST_FRAMES = 1_000_000
SHARE = 0.4
"""Of the tolerance of curves, how far a point may be off that a dense strand is drawn without. A tenth of a pixel, of a
quarter, changes a picture of 100,000 strands by .6 of 255 (root mean square), twice as much of 20,000."""


def completed(scene: Scene, roughly: bool = False) -> Scene:
    """The scene, each of its panels too, with numbers of its file in place of its defaults; the same where that has
    been done or there is no file. ``roughly``: as of `from_file`. Raises `UsageError` for a file that cannot be
    drawn."""
    panels = tuple(completed(panel, roughly) for panel in scene.panels)
    if panels != scene.panels:
        scene = replace(scene, panels=panels, time=max((panel.time for panel in panels), key=lambda one: one.frames))
    given = scene.emitter.groom
    if given is None or scene.panels or scene.emitter.followers is not None:
        return scene
    found = from_scene(scene, roughly)
    mean = found.seen.length / found.strands
    scene = replace(scene, time=_clock(scene.time, found.moments, given.start))
    scene = replace(
        scene,
        emitter=replace(
            scene.emitter, strands=found.strands, length=mean, moving=found.moments is not None,
            extent=Extent(found.seen.radius, found.seen.spacing, found.seen.area),
        ),
    )  # fmt: skip
    if not scene.guided:
        scene = replace(scene, emitter=replace(scene.emitter, particles=found.points), detail=None)
    if scene.material.width == 0:
        width = found.width
        if width is None and given.cover is not None:
            width = width_for(found.seen, given.cover)
        if width is not None:
            scene = replace(scene, material=replace(scene.material, width=width))
    if found.width is not None and scene.material.taper is None:
        scene = replace(scene, material=replace(scene.material, taper=0.0))
    if found.colour is not None:
        own = replace(scene.material, colour=found.colour, pigment="rgb", eumelanin=None, pheomelanin=None)
        scene = replace(scene, material=replace(own, tip_colour=None, grey=0.0))
    if scene.camera.fit is not None:
        later = map(some_of, found.groom.film.later()) if found.groom.film is not None else ()
        scene = replace(scene, camera=fitted(scene, np.concatenate([found.seen.points, *later])))
    if scene.guided:
        scene = with_followers(scene)
    if scene.curves.mode == "adaptive" and found.points > DENSE:
        mode, tolerance = ("off", 1.0) if scene.guided else ("thinned", SHARE)
        scene = replace(scene, curves=replace(scene.curves, mode=mode, tolerance=tolerance * scene.curves.tolerance))
    return scene


def _clock(time: Time, moments: Moments | None, start: float | None) -> Time:
    """A scene's clock, with what the file says where it has 0."""
    fps = time.fps or (moments.rate if moments is not None else USUAL)
    frames = time.frames or (min(moments.frames(fps, start), MOST_FRAMES) if moments is not None else 1)
    return replace(time, fps=fps, frames=frames)
