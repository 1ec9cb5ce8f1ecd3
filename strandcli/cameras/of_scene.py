"""A scene whose cameras are the views of a file, one a frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import UsageError, about
from ..exchange.strands import Layer
from ..exchange.usd.export import time_code
from ..scene.motion import camera_at
from . import usd
from .pinhole import Pinhole, of_camera, to_camera
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
    with about("cameras", path):
        found = views_of(path, assumed=scene.image.size, name=base.name).views
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
        camera,
        aperture=base.aperture,
        focus=base.focus,
        shutter=base.shutter,
        samples=base.samples,
        file=base.file,
        name=base.name,
    )


def views_at(scene: Scene, frames: Sequence[int]) -> list[Pinhole]:
    """The views of a scene's camera at frames, named by their numbers; one where all are the same."""
    found = []
    for frame in frames:
        camera = at_frame(scene, frame).camera
        now = camera_at(camera, (frame - 1) / scene.time.fps)
        still = replace(
            camera, position=now.position, target=now.target, fov=now.fov, height=now.height, keys=(), views=()
        )
        view = of_camera(still, f"{frame:04d}", *scene.image.size)
        found.append(replace(view, near=camera.near))
    same = all({**one.as_dict(), "name": ""} == {**found[0].as_dict(), "name": ""} for one in found)
    return found[:1] if same else found


def camera_layer(scene: Scene, frames: Sequence[int]) -> Layer:
    """A layer of USD with the scene's camera at frames, frame N at N / fps seconds."""

    def text(rate: float) -> str:
        views = views_at(scene, frames)
        codes = [time_code(frame / scene.time.fps, rate) for frame in frames][: len(views)]
        return usd.written(views, codes, rate).decode()

    return text


def at_frame(scene: Scene, frame: int) -> Scene:
    """The scene with the camera of a frame; the last view stays."""
    views = scene.camera.views
    return replace(scene, camera=views[min(frame, len(views)) - 1]) if views else scene
