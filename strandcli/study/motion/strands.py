"""The strands of a preset that a study of motion runs: grown ones, or guides of a file."""

from __future__ import annotations

from dataclasses import replace

from ...errors import UsageError
from ...groom.emit import emit
from ...groom.record import Groom
from ...scene.model import Scene


def guides_of(scene: Scene, most: int | None = None) -> Groom:
    """Return what a scene simulates, at most the first so many of the strands that it grows."""
    if scene.emitter.groom is None:
        return emit(scene.emitter, scene.seed, most)
    from ...groom_file import guided

    return guided(scene).guides


def with_fewer_guides(scene: Scene, name: str, most: int) -> Scene:
    """Return a scene that simulates at most so many of the strands of its file, where it has one. Raises `UsageError`
    where nothing moves these."""
    given = scene.emitter.groom
    if given is None:
        return scene
    if not scene.guided:
        raise UsageError(f"{name}: nothing moves the strands of its file; list a rule, or study an --axis of pictures")
    if given.guides <= most:
        return scene
    from ...groom_file import completed

    emitter = replace(scene.emitter, groom=replace(given, guides=most), followers=None)
    return completed(replace(scene, emitter=emitter))
