"""Views from a file or a folder of any kind that is known, and scenes whose cameras they are, one a frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import UsageError, about, one_line
from ..exchange.strands import Layer
from ..exchange.usd.export import time_code
from ..files.inputs import content, reading
from ..output.files import json_of
from ..scene.motion import camera_at
from . import colmap, transforms, usd
from .pinhole import UP, MissingSize, Pinhole, Views, above, from_dict, of_camera, to_camera

if TYPE_CHECKING:
    from ..scene.model import Scene

KINDS = "transforms.json, a folder of COLMAP text files, dataset.json of strandcli, or USD"
OWN = "dataset.json"
"""Of a data set that strandcli wrote."""
USD = (".usd", ".usda", ".usdc", ".usdz")
MOST = 1_000_000
"""Views of a file."""
OF_LENS = ("aperture", "focus", "shutter", "samples", "file", "name")
"""Settings of a camera that stay where its views are those of a file."""


def file_of(path: Path) -> Path:
    """The file of cameras that is meant by a folder, or the path itself. Raises `UsageError` where there is none."""
    if path.is_dir():
        found = _in_folder(path)
        if found is None:
            binary = next((path / part for part in colmap.FOLDERS if (path / part / "images.bin").is_file()), None)
            if binary is not None:
                raise UsageError(
                    f"{binary}: is binary; write text beside it: colmap model_converter --input_path {binary} "
                    f"--output_path {binary} --output_type TXT"
                )
            raise UsageError(f"{path}: has no cameras that are known: {KINDS}")
        path = found
    if not path.exists():
        raise UsageError(f"{path}: no such file")
    return path


def views_of(
    path: Path, size: tuple[int, int] | None = None, assumed: tuple[int, int] | None = None, name: str = ""
) -> Views:  # fmt: skip
    """The views of a file or a folder; ``size``: width and height, which the file may tell too if it agrees;
    ``assumed``: where it does not tell them; ``name``: of one of several cameras of USD. Raises `UsageError`, one line,
    for what cannot be read or drawn."""
    notes: list[str] = []
    path = file_of(path)
    with reading(path):
        try:
            found = _read(path, size, name, notes)
        except MissingSize:
            if assumed is None:
                raise
            found = _read(path, assumed, name, notes)
    if len(found.views) > MOST:
        raise UsageError(f"{path}: {len(found.views):,} views; {MOST:,} are read at the most")
    wrong = next((view.name for view in found.views if not view.sound), None)
    if wrong is not None:
        raise UsageError(
            f"{path}: view {one_line(wrong)[:80]}: its picture has no size or too large a one, or its focal length, "
            "principal point or place is no finite number; write the cameras anew"
        )
    return replace(found, notes=tuple(dict.fromkeys(notes)))


def _read(path: Path, size: tuple[int, int] | None, name: str, notes: list[str]) -> Views:
    """The views of a file by its kind."""
    if path.suffix.lower() in USD:
        return usd.read(path, size, name, notes)
    if name:
        raise UsageError(f"{path}: camera {name}: only files of USD have several cameras; leave out the name")
    if path.name in colmap.FILES and colmap.folder_of(path.parent) is not None:
        found, own = colmap.read(path.parent, size, notes)
    elif path.name == OWN:
        found, own = _of_strandcli(path), True
    elif path.suffix.lower() == ".json":
        found, own = transforms.read(path, size, notes)
    else:
        raise UsageError(f"{path}: is no file of cameras that is known: {KINDS}")
    return Views(found, own, above=UP if own else above(found))


def _in_folder(path: Path) -> Path | None:
    """The file of cameras in a folder, or the folder of COLMAP's files; the most exact first."""
    for name in (OWN, "transforms.json"):
        if (path / name).is_file():
            return path / name
    folder = colmap.folder_of(path)
    return None if folder is None else folder / colmap.FILES[0]


def _of_strandcli(path: Path) -> list[Pinhole]:
    """The views of a data set of strandcli, orthographic ones too. Raises `UsageError` for a file that is none."""
    try:
        data = json_of(content(path))
        views = [from_dict(entry["camera"]) for entry in data["views"]]
    except (KeyError, TypeError, ValueError, OverflowError):
        raise UsageError(f"{path}: is no {OWN} of strandcli") from None
    if not views:
        raise UsageError(f"{path}: has no view")
    return views


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
    lens = {name: getattr(base, name) for name in OF_LENS}
    cameras = tuple(replace(to_camera(view, base.near), **lens) for view in found)
    frames = len(cameras) if scene.time.frames == 1 else scene.time.frames
    return replace(
        scene,
        camera=replace(cameras[0], views=cameras),
        image=replace(scene.image, size=sizes[0]),
        time=replace(scene.time, frames=frames),
        detail=None,  # strands that one view does not need the rest may
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
