"""A scene whose cameras are the views of a file, one a frame."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import UsageError
from .pinhole import to_camera
from .read import views_of

if TYPE_CHECKING:
    from ..scene.model import Camera, Scene


def with_views(scene: Scene) -> Scene:
    """The scene, each of its panels too, with the views of ``camera.file`` in their size; the same if there is none.

    Lens, shutter and near plane stay. A scene of one frame gets one for each view. Raises `UsageError` for a file that
    cannot be drawn, and for views of several sizes.
    """
    panels = tuple(with_views(panel) for panel in scene.panels)
    if panels != scene.panels:
        scene = replace(scene, panels=panels)
    if not scene.camera.file or scene.panels:
        return scene
    path, base = Path(scene.camera.file), scene.camera
    found = views_of(path, assumed=scene.image.size).views
    sizes = sorted({(view.width, view.height) for view in found})
    if len(sizes) > 1:
        listed = " and ".join(f"{width}x{height}" for width, height in sizes[:2])
        raise UsageError(f"{path}: views are of several sizes, {listed} for two; a film has one")
    cameras = tuple(_like(to_camera(view, base.near), base) for view in found)
    frames = len(cameras) if scene.time.frames == 1 else scene.time.frames
    return replace(
        scene,
        camera=replace(cameras[0], views=cameras),
        image=replace(scene.image, size=sizes[0]),
        time=replace(scene.time, frames=frames),
        detail=None,  # strands that one view does not need others may
    )


def _like(camera: Camera, base: Camera) -> Camera:
    """A camera with the lens and shutter of another."""
    return replace(
        camera, aperture=base.aperture, focus=base.focus, shutter=base.shutter, samples=base.samples, file=base.file
    )


def at_frame(scene: Scene, frame: int) -> Scene:
    """The scene with the camera of a frame; the last view stays."""
    views = scene.camera.views
    return replace(scene, camera=views[min(frame, len(views)) - 1]) if views else scene
