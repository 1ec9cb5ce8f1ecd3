"""Simulate and draw strands (hair, fur, grass) without a GPU, a display or Blender.

>>> import strandcli
>>> scene = strandcli.load("hair")
>>> for frame in strandcli.render(scene, frames=[1, 2]):
...     frame.image, frame.positions, frame.report
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from .run.frame import Frame
    from .scene.model import Scene

__all__ = ["__version__", "load", "render"]

FILE = "emitter.groom.file"


def load(
    preset: str, overrides: Sequence[str] = (), settings: Mapping[str, Any] | None = None, *, option: str = "overrides",
) -> Scene:  # fmt: skip
    """A preset, by path or shipped name, as a validated scene.

    ``overrides`` are texts such as ``"wind.strength=3"``, as after ``--set``; ``settings`` the same with ready values.
    ``option``: by what faults name the texts, such as "--set".
    Raises `strandcli.scene.SceneError` with every fault that was found.
    """
    from .scene import load as load_scene
    from .scene.named_files import naming_files
    from .simulate.rules import registry

    scene = load_scene(preset, rules=registry(), overrides=overrides, settings=settings or {}, option=option)
    parts = scene.panels or (scene,)
    if any(one.emitter.groom is not None for one in parts):
        from .groom_file import completed

        with naming_files(None if FILE in (settings or {}) else scene):  # a file that is drawn by itself has no key
            scene = completed(scene)
    if any(one.camera.file for one in parts):
        from .cameras.read import with_views

        with naming_files(scene):
            scene = with_views(scene)
    return scene


def render(scene: Scene, frames: Sequence[int] | None = None, *, threads: int | None = None) -> Iterator[Frame]:
    """Simulate and draw; yields a `strandcli.run.frame.Frame` for each frame asked for (all by default)."""
    from .run.pipeline import render as run

    return run(scene, frames, threads=threads, keep_positions=True)
